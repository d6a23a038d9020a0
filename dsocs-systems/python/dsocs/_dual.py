"""Numbers with derivatives (forward mode of automatic differentiation)."""

from __future__ import annotations

import math
from typing import Any, Sequence

import numpy as np
import numpy.typing as npt

from ._arrays import among
from ._errors import InputTypeError
from ._inputs import unknown

Array = npt.NDArray[np.float64]


class Dual:
    """A number with its derivatives. Operators, and numpy's functions of such numbers and arrays of them, follow the chain rule."""

    __slots__ = ("slopes", "value")
    # numpy leaves operators with its numbers to this class
    __array_priority__ = 1000

    def __init__(self, value: float, slopes: Array) -> None:
        self.value = value
        self.slopes = slopes

    @staticmethod
    def parts(found: object, count: int) -> tuple[float, list[float]]:
        """The value of a cost, and its derivatives."""
        if isinstance(found, np.ndarray) and found.size == 1:
            found = found.item()
        if isinstance(found, Dual):
            slopes: list[float] = found.slopes.tolist()
            return float(found.value), slopes
        if isinstance(found, (int, float, np.number)) and not isinstance(found, bool):
            return float(found), [0.0] * count
        raise InputTypeError(f"the cost is {type(found).__name__}; expected a number that is computed from the node")

    def _with(self, value: float, slope: float) -> Dual:
        return Dual(value, slope * self.slopes)

    def __add__(self, other: Any) -> Any:
        if isinstance(other, Dual):
            return Dual(self.value + other.value, self.slopes + other.slopes)
        return Dual(self.value + other, self.slopes) if _is_number(other) else NotImplemented

    __radd__ = __add__

    def __neg__(self) -> Dual:
        return Dual(-self.value, -self.slopes)

    def __pos__(self) -> Dual:
        return self

    def __sub__(self, other: Any) -> Any:
        return self + (-other)

    def __rsub__(self, other: Any) -> Any:
        return (-self) + other

    def __mul__(self, other: Any) -> Any:
        if isinstance(other, Dual):
            return Dual(self.value * other.value, self.value * other.slopes + other.value * self.slopes)
        return self._with(self.value * other, other) if _is_number(other) else NotImplemented

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        if isinstance(other, Dual):
            quotient = self.value / other.value
            return Dual(quotient, (self.slopes - quotient * other.slopes) / other.value)
        return self._with(self.value / other, 1 / other) if _is_number(other) else NotImplemented

    def __rtruediv__(self, other: Any) -> Any:
        if not _is_number(other):
            return NotImplemented
        return self._with(other / self.value, -other / self.value**2)

    def __pow__(self, other: Any) -> Any:
        if isinstance(other, Dual):
            return (self.log() * other).exp()
        if not _is_number(other):
            return NotImplemented
        if other == 0:
            return self._with(1.0, 0.0)
        return self._with(self.value**other, other * self.value ** (other - 1))

    def __rpow__(self, other: Any) -> Any:
        if not _is_number(other):
            return NotImplemented
        value = other**self.value
        return self._with(value, value * math.log(other))

    def __abs__(self) -> Dual:
        return self._with(abs(self.value), math.copysign(1.0, self.value))

    def __lt__(self, other: Any) -> bool:
        return bool(self.value < _value(other))

    def __le__(self, other: Any) -> bool:
        return bool(self.value <= _value(other))

    def __gt__(self, other: Any) -> bool:
        return bool(self.value > _value(other))

    def __ge__(self, other: Any) -> bool:
        return bool(self.value >= _value(other))

    def __float__(self) -> float:
        raise InputTypeError(
            "a number that knows its derivative was to become one that does not: use numpy's functions (np.sin) in place of those of math"
        )

    def __repr__(self) -> str:
        return f"Dual({self.value}, {self.slopes.tolist()})"

    # numpy's functions of object arrays call these methods

    def sin(self) -> Dual:
        return self._with(math.sin(self.value), math.cos(self.value))

    def cos(self) -> Dual:
        return self._with(math.cos(self.value), -math.sin(self.value))

    def tan(self) -> Dual:
        value = math.tan(self.value)
        return self._with(value, 1 + value**2)

    def arcsin(self) -> Dual:
        return self._with(math.asin(self.value), 1 / math.sqrt(1 - self.value**2))

    def arccos(self) -> Dual:
        return self._with(math.acos(self.value), -1 / math.sqrt(1 - self.value**2))

    def arctan(self) -> Dual:
        return self._with(math.atan(self.value), 1 / (1 + self.value**2))

    def arctan2(self, other: Any) -> Dual:
        x = other if isinstance(other, Dual) else Dual(float(other), 0 * self.slopes)
        square = self.value**2 + x.value**2
        return Dual(math.atan2(self.value, x.value), (x.value * self.slopes - self.value * x.slopes) / square)

    def sinh(self) -> Dual:
        return self._with(math.sinh(self.value), math.cosh(self.value))

    def cosh(self) -> Dual:
        return self._with(math.cosh(self.value), math.sinh(self.value))

    def tanh(self) -> Dual:
        value = math.tanh(self.value)
        return self._with(value, 1 - value**2)

    def exp(self) -> Dual:
        value = math.exp(self.value)
        return self._with(value, value)

    def expm1(self) -> Dual:
        return self._with(math.expm1(self.value), math.exp(self.value))

    def log(self) -> Dual:
        return self._with(math.log(self.value), 1 / self.value)

    def log1p(self) -> Dual:
        return self._with(math.log1p(self.value), 1 / (1 + self.value))

    def sqrt(self) -> Dual:
        value = math.sqrt(self.value)
        return self._with(value, 0.5 / value)

    def cbrt(self) -> Dual:
        value = math.copysign(abs(self.value) ** (1 / 3), self.value)
        return self._with(value, 1 / (3 * value**2))

    def square(self) -> Dual:
        return self * self  # type: ignore[no-any-return]

    def hypot(self, other: Any) -> Dual:
        return (self * self + other * other).sqrt()  # type: ignore[no-any-return]

    def conjugate(self) -> Dual:
        return self


def _is_number(x: object) -> bool:
    return isinstance(x, (int, float, np.number))


def _value(x: Any) -> Any:
    return x.value if isinstance(x, Dual) else x


class DualNode:
    """A node whose numbers carry their derivatives by its position, velocity and acceleration."""

    __slots__ = ("_names", "_rotations", "a", "index", "q", "t", "v")

    def __init__(self, index: int, t: float, q: Array, v: Array, a: Array, names: Sequence[str], rotations: Sequence[int]) -> None:
        #: The number of the node.
        self.index = index
        #: The time.
        self.t = t
        self._names, self._rotations = names, rotations
        unit = np.eye(3 * len(names))
        numbers = np.empty(3 * len(names), dtype=object)
        for place, value in enumerate((*q.tolist(), *v.tolist(), *a.tolist())):
            numbers[place] = Dual(value, unit[place])
        self.q: npt.NDArray[np.object_]
        self.v: npt.NDArray[np.object_]
        self.a: npt.NDArray[np.object_]
        #: Position, velocity and acceleration: arrays with a number for each coordinate.
        self.q, self.v, self.a = numbers.reshape(3, len(names))

    def __getitem__(self, name: str) -> Any:
        """A coordinate by its name, `v_theta`, `a_theta` or `t`; an array of them, or a rotation, by its own name."""
        if name == "t":
            return self.t
        for prefix, vector in (("", self.q), ("v_", self.v), ("a_", self.a)):
            if name.startswith(prefix) and name[len(prefix) :] in self._names:
                return vector[list(self._names).index(name[len(prefix) :])]
            if not name.startswith(prefix):
                continue
            places, shape = among(name[len(prefix) :], self._names, self._rotations, moving=prefix != "")
            if places:
                return vector[places].reshape(shape)
        raise KeyError(self._missing(name))

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            # copy and pickle ask for methods before there are names
            raise AttributeError(name)
        raise AttributeError(self._missing(name))

    def _missing(self, name: str) -> str:
        moving = [x for place, x in enumerate(self._names) if place not in self._rotations]
        known = ["t", *self._names, *(f"{prefix}{x}" for prefix in ("v_", "a_") for x in moving)]
        return (
            f"{unknown('quantity', name, known)}; a cost is made of these, or of the arrays q, v and a: an observed expression, the energy or a force is "
            "written out in them"
        )
