"""Values of a printed function, with operators: each of them writes an instruction.

So a function reads like its formulas, while all of its instructions are those of `Instructions`,
with one rounding each. Where the function works on several lanes a value is one for each of them.
See `linkages.kernel.code.procedure`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Self, TypeVar

from linkages.kernel.code.elementary_functions import FUNCTIONS

if TYPE_CHECKING:
    from linkages.kernel.code.procedure import Procedure

_Kind = TypeVar("_Kind", bound="Operand")


class Operand(ABC):
    """A value, or a variable: a place in memory that is read wherever it is used.

    Parameters
    ----------
    code
        The function that it belongs to.
    text
        Its name; of a variable that of its address.
    varies
        Whether it is a variable.
    """

    kind: ClassVar[str] = ""

    def __init__(self, code: Procedure, text: str, varies: bool = False) -> None:
        self.code, self._text, self._varies = code, text, varies

    @property
    def lane_type(self) -> str:
        """Its type: a vector, where there are several lanes."""
        return self.code.of_lanes(self.kind)

    @property
    def text(self) -> str:
        """The name of its value now."""
        if self._varies:
            return self.code.give(f"load {self.lane_type}, ptr {self._text}")
        return self._text

    def set(self, value: Any) -> None:
        """Give a variable another value."""
        self.code.say(f"store {self.lane_type} {self._of(value)}, ptr {self._text}")

    @classmethod
    @abstractmethod
    def constant(cls, code: Procedure, value: Any) -> str:
        """A number of Python's as an operand."""

    @classmethod
    def of(cls, code: Procedure, value: Any) -> str:
        """The name of a value of this kind."""
        if isinstance(value, Operand):
            if type(value) is not cls:
                raise TypeError(f"expected {cls.__name__}, found {type(value).__name__}")
            return value.text
        return cls.constant(code, value)

    def _of(self, value: Any) -> str:
        return self.of(self.code, value)

    def _new(self, instruction: str) -> Self:
        return type(self)(self.code, self.code.give(instruction))

    def _truth(self, instruction: str) -> Truth:
        return Truth(self.code, self.code.give(instruction))

    def _operation(self, operation: str, other: Any, swapped: bool = False) -> Self:
        a, b = self.text, self._of(other)
        if swapped:
            a, b = b, a
        return self._new(f"{operation} {self.lane_type} {a}, {b}")

    def _relation(self, relation: str, other: Any) -> Truth:
        return self._truth(f"{relation} {self.lane_type} {self.text}, {self._of(other)}")

    def converted(self, instruction: str, kind: type[_Kind]) -> _Kind:
        """It as a value of another kind."""
        found = f"{instruction} {self.lane_type} {self.text} to {self.code.of_lanes(kind.kind)}"
        return kind(self.code, self.code.give(found))

    __hash__ = None  # type: ignore[assignment]


class Real(Operand):
    """A number."""

    kind = "double"

    @classmethod
    def constant(cls, code: Procedure, value: float) -> str:
        """A number of Python's as an operand."""
        return code.constant(float(value))

    def __add__(self, other: Real | float) -> Real:
        return self._operation("fadd", other)

    def __radd__(self, other: Real | float) -> Real:
        return self._operation("fadd", other, swapped=True)

    def __sub__(self, other: Real | float) -> Real:
        return self._operation("fsub", other)

    def __rsub__(self, other: Real | float) -> Real:
        return self._operation("fsub", other, swapped=True)

    def __mul__(self, other: Real | float) -> Real:
        return self._operation("fmul", other)

    def __rmul__(self, other: Real | float) -> Real:
        return self._operation("fmul", other, swapped=True)

    def __truediv__(self, other: Real | float) -> Real:
        return self._operation("fdiv", other)

    def __rtruediv__(self, other: Real | float) -> Real:
        return self._operation("fdiv", other, swapped=True)

    def __neg__(self) -> Real:
        return Real(self.code, self.code.negate(self.text))

    def __abs__(self) -> Real:
        return Real(self.code, self.code.absolute(self.text))

    def __lt__(self, other: Real | float) -> Truth:
        return self._relation("fcmp olt", other)

    def __le__(self, other: Real | float) -> Truth:
        return self._relation("fcmp ole", other)

    def __gt__(self, other: Real | float) -> Truth:
        return self._relation("fcmp ogt", other)

    def __ge__(self, other: Real | float) -> Truth:
        return self._relation("fcmp oge", other)

    def __eq__(self, other: Real | float) -> Truth:  # type: ignore[override]
        return self._relation("fcmp oeq", other)

    def __ne__(self, other: Real | float) -> Truth:  # type: ignore[override]
        return self._relation("fcmp une", other)

    __hash__ = None

    @property
    def whole(self) -> Whole:
        """It without its fraction, as an integer."""
        return self.converted("fptosi", Whole)

    @property
    def bits(self) -> Whole:
        """Its bits."""
        return self.converted("bitcast", Whole)


class Whole(Operand):
    """An integer, or an address."""

    kind = "i64"

    @classmethod
    def constant(cls, code: Procedure, value: int) -> str:
        """An integer of Python's as an operand."""
        return code.whole(int(value))

    def __add__(self, other: Whole | int) -> Whole:
        return self._operation("add", other)

    __radd__ = __add__

    def __sub__(self, other: Whole | int) -> Whole:
        return self._operation("sub", other)

    def __rsub__(self, other: Whole | int) -> Whole:
        return self._operation("sub", other, swapped=True)

    def __mul__(self, other: Whole | int) -> Whole:
        return self._operation("mul", other)

    __rmul__ = __mul__

    def __mod__(self, other: Whole | int) -> Whole:
        return self._operation("srem", other)

    def __floordiv__(self, other: Whole | int) -> Whole:
        return self._operation("sdiv", other)

    def __and__(self, other: Whole | int) -> Whole:
        return self._operation("and", other)

    def __lshift__(self, other: Whole | int) -> Whole:
        return self._operation("shl", other)

    def __rshift__(self, other: Whole | int) -> Whole:
        return self._operation("ashr", other)

    def __lt__(self, other: Whole | int) -> Truth:
        return self._relation("icmp slt", other)

    def __le__(self, other: Whole | int) -> Truth:
        return self._relation("icmp sle", other)

    def __gt__(self, other: Whole | int) -> Truth:
        return self._relation("icmp sgt", other)

    def __ge__(self, other: Whole | int) -> Truth:
        return self._relation("icmp sge", other)

    def __eq__(self, other: Whole | int) -> Truth:  # type: ignore[override]
        return self._relation("icmp eq", other)

    def __ne__(self, other: Whole | int) -> Truth:  # type: ignore[override]
        return self._relation("icmp ne", other)

    __hash__ = None

    @property
    def real(self) -> Real:
        """It as a number."""
        return self.converted("sitofp", Real)

    @property
    def with_bits(self) -> Real:
        """The number of these bits."""
        return self.converted("bitcast", Real)


class Shared(Whole):
    """An integer that all lanes have in common, such as the number of an entry."""

    @property
    def lane_type(self) -> str:
        """Its type."""
        return self.kind

    @classmethod
    def constant(cls, code: Procedure, value: int) -> str:  # noqa: ARG003
        """An integer of Python's as an operand."""
        return str(int(value))

    @classmethod
    def of(cls, code: Procedure, value: Any) -> str:
        """The name of such a value; a single lane has any integer for itself."""
        if isinstance(value, Whole) and code.lanes == 1:
            return value.text
        return super().of(code, value)


class Truth(Operand):
    """Whether something holds; both sides of ``&`` and ``|`` are evaluated."""

    kind = "i1"

    @classmethod
    def constant(cls, code: Procedure, value: bool) -> str:
        """True or false as an operand."""
        return code.splat(cls.kind, "true" if value else "false")

    def __and__(self, other: Truth | bool) -> Truth:
        return self._operation("and", other)

    def __or__(self, other: Truth | bool) -> Truth:
        return self._operation("or", other)

    def __invert__(self) -> Truth:
        return self._operation("xor", True)

    def __bool__(self) -> bool:
        raise TypeError("it is known only where the function runs: use `Procedure.when`")

    @property
    def real(self) -> Real:
        """1 where it holds, otherwise 0."""
        return self.converted("uitofp", Real)

    @property
    def whole(self) -> Whole:
        """1 where it holds, otherwise 0."""
        return self.converted("zext", Whole)


class Reals:
    """An array of numbers.

    Parameters
    ----------
    code
        The function that it belongs to.
    pointer
        Name of its address.
    """

    element: type[Real] | type[Whole] = Real

    def __init__(self, code: Procedure, pointer: str) -> None:
        self.code, self.pointer = code, pointer

    def after(self, count: Whole | int) -> Self:
        """What follows behind so many entries."""
        return type(self)(self.code, self._place(count))

    def _place(self, index: Whole | int) -> str:
        return self.code.address(self.pointer, index if isinstance(index, int) else index.text)

    def __getitem__(self, index: Whole | int) -> Any:
        """An entry now."""
        found = f"load {self.code.of_lanes(self.element.kind)}, ptr {self._place(index)}, align 8"
        return self.element(self.code, self.code.give(found))

    def __setitem__(self, index: Whole | int, value: Any) -> None:
        text = f"{self.code.of_lanes(self.element.kind)} {self.element.of(self.code, value)}"
        self.code.say(f"store {text}, ptr {self._place(index)}, align 8")


class Wholes(Reals):
    """An array of integers at an address."""

    element = Whole


class Fields:
    """A named tuple of integers at an address.

    Parameters
    ----------
    code
        The function that it belongs to.
    pointer
        Name of the address.
    named
        The class of the tuple.
    lasting
        Whether the address is known where the function begins: entries are then read once.
    """

    def __init__(self, code: Procedure, pointer: str, named: Any, lasting: bool = True) -> None:
        self.code, self.pointer = code, pointer
        self._places = {name: place for place, name in enumerate(named._fields)}
        self._lasting, self._known = lasting, dict[str, Whole]()

    def __getattr__(self, name: str) -> Whole:
        """An entry."""
        if name not in self._known:
            write = self.code.first if self._lasting else self.code.give
            place = write(f"getelementptr i64, ptr {self.pointer}, i64 {self._places[name]}")
            found = Whole(self.code, write(f"load i64, ptr {place}"))
            if not self._lasting:
                return found
            self._known[name] = found
        return self._known[name]


def floats(address: Any) -> Reals:
    """The numbers at an address."""
    return Reals(address.code, _pointer(address))


def integers(address: Any) -> Wholes:
    """The integers at an address."""
    return Wholes(address.code, _pointer(address))


def _pointer(address: Whole) -> str:
    return address.code.give(f"inttoptr i64 {address.text} to ptr")


def fused(a: Real, b: Real | float, c: Real | float) -> Real:
    """The value a·b + c with one rounding."""
    code = a.code
    return Real(code, code.fused(a.text, Real.of(code, b), Real.of(code, c)))


def choose(condition: Any, one: Any, other: Any) -> Any:
    """One of two values, both of which are evaluated; at least one is no constant."""
    kind = type(one) if isinstance(one, Operand) else type(other)
    return choose_of(kind, condition, one, other)


def choose_of(kind: type[Operand], condition: Any, one: Any, other: Any) -> Any:
    """One of two values of a kind."""
    code = condition.code
    texts = kind.of(code, one), kind.of(code, other)
    return kind(code, code.select(condition.text, *texts, code.of_lanes(kind.kind)))


def smaller_of(one: Any, other: Any) -> Any:
    """The smaller of two values; the first if one of them is nan."""
    return choose(other < one, other, one)


def larger_of(one: Any, other: Any) -> Any:
    """The larger of two values; the first if one of them is nan."""
    return choose(other > one, other, one)


def with_sign_of(size: Any, sign: Real) -> Real:
    """The absolute value of one number with the sign of another."""
    code = sign.code
    return Real(code, code.with_sign_of(Real.of(code, size), sign.text))


def root_of(x: Real) -> Real:
    """The square root."""
    return Real(x.code, x.code.call("llvm.sqrt", x.text))


def rounded(x: Real) -> Real:
    """The nearest integer, as a number."""
    return Real(x.code, x.code.call("llvm.rint", x.text))


def floor_of(x: Real) -> Whole:
    """The largest integer that is not larger."""
    return Real(x.code, x.code.call("llvm.floor", x.text)).whole


def polynomial(x: Real, coefficients: Sequence[float]) -> Real:
    """The value of Σ c_k x^k by Horner's rule."""
    return Real(x.code, x.code.polynomial(x.text, coefficients))


def elementary(name: str, *given: Real) -> Real:
    """A function by its name in `linkages.operations`, written out where that is known."""
    code, texts = given[0].code, [x.text for x in given]
    return Real(
        code, FUNCTIONS[name](code, *texts) if name in FUNCTIONS else code.library(name, *texts)
    )
