"""Systems from expressions."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import CURVED, ROD

import dsocs
from dsocs import System, coordinates, ddot, dot, parameter, where

x, y = coordinates("x", "y")
length = parameter("length", 1.0, "The length of the rod [m]")


@pytest.mark.parametrize(
    ("expression", "text"),
    [
        (x + y * 2, "x + y * 2.0"),
        ((x + y) * 2, "(x + y) * 2.0"),
        (x - (y - 1), "x - (y - 1.0)"),
        (x / (y * 2), "x / (y * 2.0)"),
        (x / y / 2, "x / y / 2.0"),
        (-x, "-x"),
        ((-x) ** 2, "(-x).powi(2)"),
        (-(x**2), "-x.powi(2)"),
        (2 - x, "2.0 - x"),
        (x - -2.0, "x - -2.0"),
        (x**0.5, "x.powf(0.5)"),
        (x ** (y + 1), "x.powf(y + 1.0)"),
        (2**x, "2.0.powf(x)"),
        (np.sin(x), "x.sin()"),
        (np.sqrt(x + y), "(x + y).sqrt()"),
        (np.float64(2) * x, "2.0 * x"),
        (abs(x), "x.abs()"),
        (np.abs(x), "x.abs()"),
        (np.sign(x), "x.signum()"),
        (np.arctan2(y, x), "y.atan2(x)"),
        (dot(x) * ddot(y), "dot(x) * ddot(y)"),
        (dot(x * y), "dot(x * y)"),
        (1e-20 * x, "1e-20 * x"),
        (dsocs.time * x, "t * x"),
        (where(x < 1, x, y), "(if x < 1.0 { x } else { y })"),
        (np.square(x), "x.powi(2)"),
        (np.log(x) + np.exp(y), "x.ln() + y.exp()"),
    ],
)
def test_an_expression_is_printed(expression: dsocs.Expression, text: str) -> None:
    assert str(expression) == text


@pytest.mark.parametrize("function", [np.sin, np.cos, np.tan, np.arctan, np.sinh, np.cosh, np.tanh, np.arcsinh, np.exp, np.expm1, np.sqrt, np.cbrt, np.log, np.log1p, np.abs])
def test_numpys_functions_have_their_values(function: np.ufunc) -> None:
    (z,) = coordinates("z")
    system = System.of(coordinates=(z,), lagrangian=dot(z) ** 2 / 2, observe={"value": function(z + 1.5)})
    run = system.flow(h=0.01, q=[0.25], v=[0.5]).until(0.1)
    np.testing.assert_allclose(run["value"], function(run["z"] + 1.5), rtol=4e-16)


def test_arrays_of_expressions() -> None:
    q = np.array(coordinates("x", "y"))
    (kinetic,) = [sum(dot(part) ** 2 for part in q) / 2]
    system = System.of(coordinates=q, lagrangian=kinetic - 9.81 * q[1], holonomic=(q**2).sum() - 1)
    assert isinstance(np.sin(q)[0], dsocs.Expression) and str((2 * q)[1]) == "2.0 * y"
    np.testing.assert_allclose(system.flow(h=0.01, q=[0, -1], v=[1, 0]).until(1.0).q, dsocs.System(ROD).flow(h=0.01, q=[0, -1], v=[1, 0]).until(1.0).q, rtol=1e-12)


def test_expressions_and_text_are_one_system() -> None:
    mass, curvature = parameter("mass", 1.0), parameter("curvature", 0.5)
    speed = np.sqrt(dot(x) ** 2 + dot(y) ** 2)
    system = System.of(
        coordinates=(x, y),
        lagrangian=mass / 2 * (dot(x) ** 2 + dot(y) ** 2),
        kinematic=(dot(x) * ddot(y) - ddot(x) * dot(y)) / speed**3 - curvature,
        variational=[(dot(x), dot(y))],
    )
    own, text = (of.flow(q=[0, 0], v=[1, 0], h=0.05).until(5.0) for of in (system, dsocs.System(CURVED)))
    np.testing.assert_array_equal(own.q, text.q)
    assert dsocs.System(system.text) == system


def test_what_occurs_twice_is_written_once() -> None:
    part = np.sin(x + y)
    deep = part
    for _ in range(60):
        deep = deep * deep + 1
    text = System.of(coordinates=(x, y), lagrangian=(dot(x) ** 2 + dot(y) ** 2) / 2, observe={"part": part * part}).text
    assert text.count("sin()") == 1 and "let e0 = (x + y).sin();" in text
    assert len(str(parameter("a", 1.0) + 1)) < 20 and deep is not None


def test_documentation_and_order_are_kept() -> None:
    u, w = coordinates("u", "w", doc={"u": "The first place [m]"})
    system = System.of(coordinates=(w, u), lagrangian=(dot(u) ** 2 + dot(w) ** 2) / 2 * length, doc="Two places.")
    assert [of.name for of in system.coordinates] == ["w", "u"] and system.coordinates[1].unit == "m"
    assert system.quantity("length").meaning == "The length of the rod" and system.doc == "Two places."


def test_forces_by_name_and_choices() -> None:
    system = System.of(
        coordinates=(x, y), lagrangian=(dot(x) ** 2 + dot(y) ** 2) / 2, external_forces={"y": where(dsocs.time < 0.5, 1, 0)}
    )
    with pytest.warns(dsocs.StepWarning):
        run = system.flow(q=[0, 0], v=[0, 0], h=0.11).until(2.0)
    assert run["x"][-1] == 0.0 and run["v_y"][-1] == pytest.approx(0.5, abs=0.06)


def test_a_mistake_names_the_statement() -> None:
    with pytest.raises(dsocs.DeclarationError) as raised:
        System.of(coordinates=(x, y), lagrangian=(dot(x) ** 2 + dot(y) ** 2) / 2, kinematic=[dot(x) - 1])
    assert "kinematic = dot(x) - 1.0;" in str(raised.value)


def test_sympy_in_and_out() -> None:
    sympy = pytest.importorskip("sympy")
    from sympy.physics.mechanics import dynamicsymbols

    theta = dynamicsymbols("theta")
    m, l, g = sympy.symbols("m l g")
    t = dynamicsymbols._t
    lagrangian = m * l**2 * theta.diff(t) ** 2 / 2 + m * g * l * sympy.cos(theta)
    system = System.of(coordinates=(theta,), lagrangian=lagrangian, parameters={"m": 1.0, "l": 1.0, "g": 9.81})
    own = dsocs.System("coordinates(theta); lagrangian = dot(theta).powi(2) / 2 + 9.81 * theta.cos();")
    np.testing.assert_allclose(system.flow(h=0.01, q=[1], v=[0]).until(2.0).q, own.flow(h=0.01, q=[1], v=[0]).until(2.0).q, rtol=1e-10)
    (q,) = coordinates("q")
    back = dsocs.to_sympy(parameter("m", 1.0) * dot(q) ** 2 / 2 + np.cos(q))
    f, s = sympy.Function("q"), sympy.Symbol("t")
    assert sympy.simplify(back - (sympy.Symbol("m") * f(s).diff(s) ** 2 / 2 + sympy.cos(f(s)))) == 0


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda sympy, q, t: q.diff(t) ** 2 * sympy.Symbol("k"), "the symbol `k`"),
        (lambda sympy, q, t: q.diff(t) ** 2 + sympy.gamma(q), "gamma"),
        (lambda sympy, q, t: q.diff(t) ** 2 + sympy.Function("other")(t), "other"),
        (lambda sympy, q, t: q.diff(t) ** 2 + sympy.Symbol("t2"), "t2"),
        (lambda sympy, q, t: q.diff(t) ** 2 + q * sympy.Function("other")(t), r"sympy.Symbol\('other'\) and parameters={'other': …}"),
        (lambda sympy, q, t: q.diff(t) ** 2 + q * sympy.Symbol("t", positive=True), "dynamicsymbols._t"),
        (lambda sympy, q, t: q.diff(t) ** 2 - sympy.Piecewise((q, q > 0)), "has no value where none of its conditions holds"),
        (lambda sympy, q, t: q.diff(t) ** 2 - sympy.Heaviside(q), "what stands for it is Piecewise"),
        (lambda sympy, q, t: q.diff(t) ** 2 - sympy.sec(q), r"what stands for it is 1/cos\(x\)"),
        (lambda sympy, q, t: q.diff(t) ** 2 - sympy.sinc(q), r"what stands for it is sin\(x\)/x"),
    ],
)
def test_sympy_that_is_no_declaration(make: object, said: str) -> None:
    sympy = pytest.importorskip("sympy")
    from sympy.physics.mechanics import dynamicsymbols

    q = dynamicsymbols("q")
    with pytest.raises(dsocs.SetupError, match=said):
        System.of(coordinates=(q,), lagrangian=make(sympy, q, dynamicsymbols._t))  # type: ignore[operator]


def test_sympy_of_two_symbols_with_one_name() -> None:
    sympy = pytest.importorskip("sympy")
    from sympy.physics.mechanics import dynamicsymbols

    q, t = dynamicsymbols("q"), dynamicsymbols._t
    one, other = sympy.Symbol("m", positive=True), sympy.Symbol("m")
    lagrangian = one * q.diff(t) ** 2 / 2 + other * q
    with pytest.raises(dsocs.SetupError, match="the parameter `m` has two values, 1 and 2"):
        System.of(coordinates=q, lagrangian=lagrangian, parameters={one: 1.0, other: 2.0})
    assert System.of(coordinates=q, lagrangian=lagrangian, parameters={one: 2.0, other: 2.0}).parameters == {"m": 2.0}


def test_sympy_in_matrices_equations_and_by_coordinate() -> None:
    sympy = pytest.importorskip("sympy")
    from sympy.physics.mechanics import dynamicsymbols

    q, p = dynamicsymbols("q p")
    t = dynamicsymbols._t
    v, w = q.diff(t), p.diff(t)
    kinetic = (v**2 + w**2) / 2

    def text(**parts: object) -> str:
        return System.of(**{"coordinates": [q, p], "lagrangian": kinetic, **parts}).text  # type: ignore[arg-type]

    rates = sympy.Matrix([v, w])
    assert text(coordinates=sympy.Matrix([q, p])) == text()
    assert text(lagrangian=rates.T * rates / 2) == text(lagrangian=v**2 / 2 + w**2 / 2)
    for matrix in (sympy.Matrix([-v, -w]), sympy.Matrix([[-v, -w]]), sympy.ImmutableMatrix([-v, -w])):
        assert text(external_forces=matrix) == text(external_forces=[-v, -w]) == text(external_forces={q: -v, p: -w})
    row = q**2 + p**2 - 1
    assert text(holonomic=sympy.Matrix([row])) == text(holonomic=row) == text(holonomic=sympy.Eq(row, 0))
    assert "-1.0" in text(holonomic=[sympy.Eq(q**2 + p**2, 1)])
    rolling = dict(nonholonomic=v - t * w)
    forms = [text(**rolling, constraint_forces=of) for of in ([(1, -t)], sympy.Matrix([[1, -t]]), sympy.Matrix([1, -t]), [sympy.Matrix([1, -t])])]
    assert len(set(forms)) == 1
    assert System.of(coordinates=q, lagrangian=v**2 / 2).text == System.of(coordinates=[q], lagrangian=v**2 / 2).text
    with pytest.raises(dsocs.SetupError, match=r"`X` is no function of the time alone: sympy.physics.mechanics.dynamicsymbols\('X'\) is one"):
        System.of(coordinates=sympy.Symbol("X"), lagrangian=1)


@pytest.mark.parametrize(
    ("make", "own"),
    [
        (lambda sympy, q: -sympy.Max(q, 0.5), "-q.max(0.5)"),
        (lambda sympy, q: -sympy.Min(q, 0.5, -q), "-q.min(0.5).min(-q)"),
        (lambda sympy, q: sympy.Piecewise((-q, sympy.And(q > 0, q < 0.5)), (-1, True)), "if q <= 0 { -1 } else { if q < 0.5 { -q } else { -1 } }"),
        (lambda sympy, q: sympy.Piecewise((-q, sympy.Or(q < 0, q > 0.5)), (1, True)), "if q < 0 { -q } else { if q <= 0.5 { 1 } else { -q } }"),
        (lambda sympy, q: sympy.Piecewise((-q, q < 0), (-2 * q, q < 0.5), (-1, True)), "if q < 0 { -q } else { if q < 0.5 { -2 * q } else { -1 } }"),
    ],
)
@pytest.mark.filterwarnings("ignore::dsocs.StepWarning")
def test_sympy_that_chooses(make: object, own: str) -> None:
    sympy = pytest.importorskip("sympy")
    from sympy.physics.mechanics import dynamicsymbols

    q = dynamicsymbols("q")
    system = System.of(coordinates=q, lagrangian=q.diff() ** 2 / 2, external_forces=[make(sympy, q)])  # type: ignore[operator]
    text = dsocs.System(f"coordinates(q); lagrangian = dot(q).powi(2) / 2; external_forces = {own};")
    one, other = (of.flow(h=0.01, q=[1.0], v=[-0.5]).until(4.0).q for of in (system, text))
    np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-12)


def test_sympy_and_expressions_do_not_mix() -> None:
    sympy = pytest.importorskip("sympy")
    a = sympy.Symbol("a")
    for mix in (lambda: x * a, lambda: a * x, lambda: x + a, lambda: sympy.sin(x)):
        with pytest.raises(dsocs.InputTypeError, match="meets one of sympy: write a system in one of the two"):
            mix()


def test_values_of_parameters_are_taken_and_others_refused() -> None:
    x, = dsocs.coordinates("x")
    k = dsocs.parameter("k", 2.0, "The stiffness [N/m]")
    lagrangian = dsocs.dot(x) ** 2 / 2 - k * x**2
    system = dsocs.System.of(coordinates=x, lagrangian=lagrangian, parameters={"k": 5.0})
    assert system.parameters == {"k": 5.0} and system.quantity("k").unit == "N/m"
    with pytest.raises(dsocs.SetupError, match="there is no parameter `kk` .did you mean `k`."):
        dsocs.System.of(coordinates=x, lagrangian=lagrangian, parameters={"kk": 5.0})
    with pytest.raises(dsocs.InputTypeError, match="parameters is list"):
        dsocs.System.of(coordinates=x, lagrangian=lagrangian, parameters=[5.0])  # type: ignore[arg-type]
    # a dict that several systems share
    shared = {"m": 1.0, "k": 5.0, "g": 9.81}
    with pytest.raises(dsocs.SetupError, match="no expression contains the parameters `m`, `g`; the system has k") as raised:
        dsocs.System.of(coordinates=x, lagrangian=lagrangian, parameters=shared)
    advised = str(raised.value).split("parameters=")[-1]
    assert dsocs.System.of(coordinates=x, lagrangian=lagrangian, parameters=eval(advised, {"shared": shared})).parameters == {"k": 5.0}
    with pytest.raises(dsocs.SetupError, match="no expression contains `g`; leave it out"):
        dsocs.System.of(coordinates=x, lagrangian=lagrangian, parameters={"k": 5.0, "g": 9.81})


@pytest.mark.parametrize("name", ["v_x", "a_x", "force_x", "error_x", "lambda_0", "energy"])
def test_parameters_have_no_name_of_a_column(name: str) -> None:
    said = f"`{name}` is the column of .*expected another name"
    x, = dsocs.coordinates("x")
    with pytest.raises(dsocs.DeclarationError, match=said):
        dsocs.System.of(coordinates=x, lagrangian=dsocs.dot(x) ** 2 * dsocs.parameter(name, 2.0))
    with pytest.raises(dsocs.DeclarationError, match=said):
        dsocs.System(f"parameters {{ {name} = 2.0 }} coordinates(x); lagrangian = {name} * dot(x).powi(2);")
    # nor is an observed expression called as a parameter, which the column would hide
    for own, kind in (("m", "parameter"), ("x", "coordinate")):
        with pytest.raises(dsocs.SetupError, match=f"`{own}`, which is the name of a {kind}; take another name"):
            dsocs.System.of(coordinates=x, lagrangian=dsocs.dot(x) ** 2 * dsocs.parameter("m", 2.0), observe={own: 2 * x})


@pytest.mark.parametrize("name", ["h", "tau", "t1"])
def test_symbols_that_mean_something_are_refused_with_a_cure(name: str) -> None:
    sympy = pytest.importorskip("sympy")
    from sympy.physics.mechanics import dynamicsymbols

    q, symbol = dynamicsymbols("q"), sympy.Symbol(name)
    lagrangian = q.diff() ** 2 * symbol / 2
    if name == "t1":
        assert System.of(coordinates=(q,), lagrangian=lagrangian, parameters={symbol: 2.0}).parameters == {"t1": 2.0}
        return
    for parameters in ({symbol: 2.0}, {}):
        with pytest.raises(dsocs.SetupError, match=f"the symbol `{name}` cannot be a parameter: .*take a symbol of another name, sympy.Symbol.'{name}1'.") as raised:
            System.of(coordinates=(q,), lagrangian=lagrangian, parameters=parameters)
        assert f".subs({name}, sympy.Symbol('{name}1'))" in str(raised.value)
    with pytest.raises(dsocs.SetupError, match=f"take another name, such as `{name}1`"):
        dsocs.parameter(name, 1.0)


def test_parameters_of_sympy_have_the_order_of_their_dict() -> None:
    sympy = pytest.importorskip("sympy")
    from sympy.physics.mechanics import dynamicsymbols

    q = dynamicsymbols("q")
    m, k, b, a = sympy.symbols("m k b a")
    lagrangian = m * q.diff() ** 2 / 2 - k * q**2 / 2 - a * b * q
    for values in ({m: 1.0, k: 2.0, b: 3.0, a: 4.0}, {a: 4.0, k: 2.0, m: 1.0, b: 3.0}):
        system = System.of(coordinates=(q,), lagrangian=lagrangian, parameters=values)
        assert list(system.parameters.items()) == [(str(symbol), value) for symbol, value in values.items()]


def test_mistakes_with_expressions_say_what_is_meant() -> None:
    x, = dsocs.coordinates("x")
    with pytest.raises(dsocs.InputTypeError, match=r"write dsocs.where\(a < b, x, y\)"):
        np.where(x < 1, x, -x)
    theta = dsocs.coordinates("theta")
    with pytest.raises(dsocs.InputTypeError, match=r"`theta, = dsocs.coordinates\('theta'\)`"):
        dsocs.dot(theta)  # type: ignore[arg-type]
    with pytest.raises(dsocs.InputTypeError, match="doc is 'The angle'; expected a dict"):
        dsocs.coordinates("x", doc="The angle")  # type: ignore[arg-type]
    with pytest.raises(dsocs.InputTypeError, match="expected a dict of expressions by the names"):
        dsocs.System.of(coordinates=x, lagrangian=dsocs.dot(x) ** 2, observe=[x])  # type: ignore[arg-type]
    with pytest.raises(dsocs.SetupError, match="`t` cannot be the name of an observed expression"):
        dsocs.System.of(coordinates=x, lagrangian=dsocs.dot(x) ** 2, observe={"t": x})
    for name, meaning in (("t", "the time"), ("h", "the step"), ("dot", "the time derivative")):
        with pytest.raises(dsocs.SetupError, match=f"`{name}` cannot be the name of a coordinate: in a declaration it is {meaning}"):
            dsocs.coordinates(name)
    with pytest.raises(dsocs.InputTypeError, match="path is 3; expected the name of a file"):
        dsocs.System.of(coordinates=x, lagrangian=dsocs.dot(x) ** 2).flow(h=0.1, q=[0], v=[0]).report(3)  # type: ignore[arg-type]
