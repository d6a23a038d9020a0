"""Taylor coefficients of elementary functions of a polynomial, to 20 digits: taylor_coefficients.csv.

Needs mpmath. Each function is taken of u(t) = 2/5 + 7/10 t + 3/20 t^2 and du = u'(t), and differentiated at t = 0 by
contour integrals (the mean of f over a circle inside of the disc where it is analytic), which share nothing with the
recurrences that are tested.

    python3 make_taylor_coefficients.py > taylor_coefficients.csv
"""

from mpmath import *

mp.dps = 60
ORDER = 30
POINTS = 4096
# u = 0 at the distance 0.656, the nearest singularity of all; the error is (RADIUS / distance)^(POINTS - ORDER)
RADIUS = mpf("0.5")

FUNCTIONS = {
    "product": lambda u, du: u * du,
    "square": lambda u, du: u * u,
    "fifth": lambda u, du: u**5,
    "reciprocal": lambda u, du: 1 / (1 + u),
    "quotient": lambda u, du: u / (1 + u * u),
    "sqrt": lambda u, du: sqrt(u),
    "cbrt": lambda u, du: cbrt(u),
    "powf": lambda u, du: u ** mpf("2.3"),
    "power": lambda u, du: (1 + u) ** du,
    "exp": lambda u, du: exp(u),
    "exp_m1": lambda u, du: expm1(u),
    "ln": lambda u, du: log(u),
    "ln_1p": lambda u, du: log1p(u),
    "sin": lambda u, du: sin(u),
    "cos": lambda u, du: cos(u),
    "tan": lambda u, du: tan(u),
    "asin": lambda u, du: asin(u / 2),
    "acos": lambda u, du: acos(u / 2),
    "atan": lambda u, du: atan(u),
    "atan2": lambda u, du: atan(u / (1 + du)),
    "sinh": lambda u, du: sinh(u),
    "cosh": lambda u, du: cosh(u),
    "tanh": lambda u, du: tanh(u),
    "asinh": lambda u, du: asinh(u),
    "acosh": lambda u, du: acosh(3 + u),
    "atanh": lambda u, du: atanh(u / 2),
    "abs": lambda u, du: u * sin(u),
    "signum": lambda u, du: -sin(u),
    "select": lambda u, du: exp(u) * u,
    "nested": lambda u, du: exp(sin(u) / (1 + du**2)),
}

roots = [expjpi(mpf(2 * j) / POINTS) for j in range(POINTS)]
print("function,order,coefficient")
for name, function in FUNCTIONS.items():
    values = []
    for root in roots[: POINTS // 2 + 1]:
        t = RADIUS * root
        u = mpf(2) / 5 + mpf(7) / 10 * t + mpf(3) / 20 * t * t
        values.append(function(u, mpf(7) / 10 + mpf(3) / 10 * t))
    for k in range(ORDER + 1):
        # f(conj t) = conj f(t): the lower half of the circle is the mirror of the upper one
        inner = fsum(re(values[j] * roots[(-j * k) % POINTS]) for j in range(1, POINTS // 2))
        ends = re(values[0]) + re(values[-1]) * (-1) ** k
        coefficient = (2 * inner + ends) / POINTS / RADIUS**k
        # what is left of a polynomial beyond its degree is rounding
        coefficient = coefficient if abs(coefficient) > mpf("1e-40") else mpf(0)
        print(f"{name},{k},{nstr(coefficient, 20)}")
