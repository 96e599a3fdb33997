"""Values of a traced function, with operators: each of them writes an instruction.

So a function reads like its formulas. With several lanes a value is one for each of them.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any, ClassVar, Self, TypeVar, get_type_hints

if TYPE_CHECKING:
    from linkages.kernel.code.procedure import Procedure

_Kind = TypeVar("_Kind", bound="Operand")


class Operand(ABC):
    """A value, or a variable (it `varies`): a place in memory that is read wherever it is used."""

    kind: ClassVar[str] = ""

    def __init__(self, code: Procedure, text: str, varies: bool = False) -> None:
        self.code, self._text, self._varies = code, text, varies

    @property
    def lane_type(self) -> str:
        """Its type: a vector, where there are several lanes."""
        return self.code.vector_type(self.kind)

    @property
    def text(self) -> str:
        """The name of its value now."""
        if self._varies:
            return self.code.assign(f"load {self.lane_type}, ptr {self._text}")
        return self._text

    def set(self, value: Any) -> None:
        """Give a variable another value."""
        self.code.emit(f"store {self.lane_type} {self.of(self.code, value)}, ptr {self._text}")

    @classmethod
    @abstractmethod
    def constant(cls, code: Procedure, value: Any) -> str:
        """A number of Python's as an operand."""

    @classmethod
    def of(cls, code: Procedure, value: Any) -> str:
        """The name of a value of this kind."""
        if type(value) is cls:
            return value.text
        if isinstance(value, Operand):
            raise TypeError(f"expected {cls.__name__}, found {type(value).__name__}")
        return cls.constant(code, value)

    def _new(self, instruction: str) -> Self:
        return type(self)(self.code, self.code.assign(instruction))

    def _operation(self, operation: str, other: Any, swapped: bool = False) -> Self:
        a, b = self.text, self.of(self.code, other)
        if swapped:
            a, b = b, a
        return self._new(f"{operation} {self.lane_type} {a}, {b}")

    def _relation(self, relation: str, other: Any) -> Bool:
        text = f"{relation} {self.lane_type} {self.text}, {self.of(self.code, other)}"
        return Bool(self.code, self.code.assign(text))

    def converted(self, instruction: str, kind: type[_Kind]) -> _Kind:
        """It as a value of another kind."""
        result = f"{instruction} {self.lane_type} {self.text} to {self.code.vector_type(kind.kind)}"
        return kind(self.code, self.code.assign(result))

    __hash__ = None  # type: ignore[assignment]


_Own = TypeVar("_Own", bound=Operand)


def _operator(instruction: str, swapped: bool = False) -> Callable[[_Own, Any], _Own]:
    """A method that writes an instruction with another value on its right, or on its left."""
    return lambda self, other: self._operation(instruction, other, swapped)


def _relation(instruction: str) -> Callable[[Operand, Any], Bool]:
    return lambda self, other: self._relation(instruction, other)


class Real(Operand):
    """A number."""

    kind = "double"

    @classmethod
    def constant(cls, code: Procedure, value: float) -> str:
        return code.constant(float(value))

    __add__, __radd__ = _operator("fadd"), _operator("fadd", swapped=True)
    __sub__, __rsub__ = _operator("fsub"), _operator("fsub", swapped=True)
    __mul__, __rmul__ = _operator("fmul"), _operator("fmul", swapped=True)
    __truediv__, __rtruediv__ = _operator("fdiv"), _operator("fdiv", swapped=True)
    __lt__, __le__ = _relation("fcmp olt"), _relation("fcmp ole")
    __gt__, __ge__ = _relation("fcmp ogt"), _relation("fcmp oge")
    __eq__, __ne__ = _relation("fcmp oeq"), _relation("fcmp une")  # type: ignore[assignment]

    def __neg__(self) -> Real:
        return self._new(f"fneg {self.lane_type} {self.text}")

    def __abs__(self) -> Real:
        return Real(self.code, self.code.call_intrinsic("llvm.fabs", self.text))

    __hash__ = None

    @property
    def to_int(self) -> Int:
        """It without its fraction, as an integer."""
        return self.converted("fptosi", Int)

    @property
    def bits(self) -> Int:
        """Its bits."""
        return self.converted("bitcast", Int)


class Int(Operand):
    """An integer, or an address."""

    kind = "i64"

    @classmethod
    def constant(cls, code: Procedure, value: int) -> str:
        return code.int_constant(int(value))

    __add__ = __radd__ = _operator("add")
    __sub__, __rsub__ = _operator("sub"), _operator("sub", swapped=True)
    __mul__ = __rmul__ = _operator("mul")
    __mod__ = _operator("srem")
    __floordiv__ = _operator("sdiv")
    __and__ = _operator("and")
    __lshift__ = _operator("shl")
    __rshift__ = _operator("ashr")
    __xor__ = _operator("xor")
    __lt__, __le__ = _relation("icmp slt"), _relation("icmp sle")
    __gt__, __ge__ = _relation("icmp sgt"), _relation("icmp sge")
    __eq__, __ne__ = _relation("icmp eq"), _relation("icmp ne")  # type: ignore[assignment]
    __hash__ = None

    @property
    def to_real(self) -> Real:
        """It as a number."""
        return self.converted("sitofp", Real)

    @property
    def with_bits(self) -> Real:
        """The number of these bits."""
        return self.converted("bitcast", Real)


class UniformInt(Int):
    """An integer that all lanes have in common, such as the number of an entry."""

    @property
    def lane_type(self) -> str:
        return self.kind

    @classmethod
    def constant(cls, code: Procedure, value: int) -> str:  # noqa: ARG003
        return str(int(value))

    @classmethod
    def of(cls, code: Procedure, value: Any) -> str:
        """The name of such a value; a single lane has any integer for itself."""
        if isinstance(value, Int) and code.lanes == 1:
            return value.text
        return super().of(code, value)


class Bool(Operand):
    """Whether something holds; both sides of ``&`` and ``|`` are evaluated."""

    kind = "i1"

    @classmethod
    def constant(cls, code: Procedure, value: bool) -> str:
        return code.splat(cls.kind, "true" if value else "false")

    def __and__(self, other: Bool | bool) -> Bool:
        return self._operation("and", other)

    def __or__(self, other: Bool | bool) -> Bool:
        return self._operation("or", other)

    def __invert__(self) -> Bool:
        return self._operation("xor", True)

    def __bool__(self) -> bool:
        raise TypeError("it is known only where the function runs: use `Procedure.when`")

    @property
    def to_real(self) -> Real:
        """1 where it holds, otherwise 0."""
        return self.converted("uitofp", Real)

    @property
    def to_int(self) -> Int:
        """1 where it holds, otherwise 0."""
        return self.converted("zext", Int)


class Place:
    """What is at an address."""

    kind = "ptr"

    def __init__(self, code: Procedure, pointer: str) -> None:
        self.code, self.pointer = code, pointer

    @property
    def text(self) -> str:
        """The name of the address."""
        return self.pointer

    @classmethod
    def of(cls, _code: Procedure, value: Place) -> str:
        """The name of the address of such a value."""
        return value.pointer

    @classmethod
    def at(cls, address: Int) -> Self:
        """That at an address which is a number."""
        return cls(address.code, address.code.assign(f"inttoptr i64 {address.text} to ptr"))


class RealArray(Place):
    """An array of numbers."""

    element: type[Real] | type[Int] = Real

    def after(self, count: Int | int) -> Self:
        """What follows behind so many entries."""
        return type(self)(self.code, self._place(count))

    def _place(self, index: Int | int) -> str:
        return self.code.address(self.pointer, index if isinstance(index, int) else index.text)

    def __getitem__(self, index: Int | int) -> Any:
        result = (
            f"load {self.code.vector_type(self.element.kind)}, ptr {self._place(index)}, align 8"
        )
        return self.element(self.code, self.code.assign(result))

    def __setitem__(self, index: Int | int, value: Any) -> None:
        text = f"{self.code.vector_type(self.element.kind)} {self.element.of(self.code, value)}"
        self.code.emit(f"store {text}, ptr {self._place(index)}, align 8")

    def take(self, source: RealArray, count: Any) -> None:
        """Copy the first entries of another array."""
        with self.code.for_range(count) as i:
            self[i] = source[i]


class IntArray(RealArray):
    """An array of integers."""

    element = Int


class Entry:
    """One of some `Numbers`, read and written by its name; by the class its name is its place."""

    def __init__(self, kind: type[Real] | type[Int] = Real) -> None:
        self._array = RealArray if kind is Real else IntArray

    def __set_name__(self, owner: type[Numbers], _name: str) -> None:
        self._place = owner.entries().index(self)

    def __get__(self, own: Numbers | None, _owner: type[Numbers]) -> Any:
        if own is None:
            return self._place
        return self._array(own.code, own.pointer)[own.offset(self._place)]

    def __set__(self, own: Numbers, value: Any) -> None:
        self._array(own.code, own.pointer)[own.offset(self._place)] = value


class Numbers(Place):
    """Numbers that have names, one behind the other, or a `stride` apart."""

    def __init__(self, code: Procedure, pointer: str, stride: Int | None = None) -> None:
        super().__init__(code, pointer)
        self._stride = stride

    @classmethod
    def entries(cls) -> list[Entry]:
        """All of them."""
        return [entry for entry in vars(cls).values() if isinstance(entry, Entry)]

    def offset(self, place: int) -> Int | int:
        """Where one of them is."""
        return place if self._stride is None else self._stride * place


class Function(Place):
    """A compiled function, or none where the address is 0."""

    @property
    def exists(self) -> Bool:
        """Whether there is one."""
        return Bool(self.code, self.code.assign(f"icmp ne ptr {self.pointer}, null"))

    def __call__(self, result: type[_Kind], *given: Operand | Place) -> _Kind:
        texts = ", ".join(f"{each.kind} {each.text}" for each in given)
        call = f"call {result.kind} {self.pointer}({texts})"
        return result(self.code, self.code.assign(call))


class Table(Place):
    """Entries of 8 bytes, one behind the other: those that a subclass annotates.

    An `Int` is an integer, another `Table` a part of this one, and anything else the address of
    what is there. If the address is `lasting`, entries are read once, where the function begins.
    """

    def __init__(self, code: Procedure, pointer: str, lasting: bool = True) -> None:
        super().__init__(code, pointer)
        self._lasting = lasting

    @classmethod
    def at(cls, address: Int) -> Self:
        """That at an address which is a number, found on the way."""
        return cls(address.code, super().at(address).pointer, lasting=False)

    @classmethod
    @cache
    def places(cls) -> dict[str, int]:
        """Name of each entry → number of those before it."""
        result, place = {}, 0
        for name, kind in cls.kinds().items():
            result[name] = place
            place += _words(kind)
        return result

    @classmethod
    @cache
    def words(cls) -> int:
        """Number of entries, with those of the tables that are parts."""
        return sum(map(_words, cls.kinds().values()))

    @classmethod
    @cache
    def kinds(cls) -> dict[str, Any]:
        """Name of each entry → what it is."""
        return get_type_hints(cls)

    def __getattr__(self, name: str) -> Any:
        if name not in self.kinds():
            raise AttributeError(name)
        kind = self.kinds()[name]
        write = self.code.assign_at_entry if self._lasting else self.code.assign
        place = write(f"getelementptr i64, ptr {self.pointer}, i64 {self.places()[name]}")
        if issubclass(kind, Table):
            result = kind(self.code, place, self._lasting)
        else:
            result = kind(self.code, write(f"load {kind.kind}, ptr {place}"))
        if self._lasting:
            vars(self)[name] = result
        return result


def _words(kind: Any) -> int:
    return kind.words() if issubclass(kind, Table) else 1


def floats(address: Int) -> RealArray:
    """The numbers at an address."""
    return RealArray.at(address)


def integers(address: Int) -> IntArray:
    """The integers at an address."""
    return IntArray.at(address)


def fma(a: Real, b: Real | float, c: Real | float) -> Real:
    """The value a·b + c with one rounding."""
    code = a.code
    texts = a.text, Real.of(code, b), Real.of(code, c)
    return Real(code, code.call_intrinsic("llvm.fma", *texts))


def select(condition: Any, one: Any, other: Any) -> Any:
    """One of two values, both of which are evaluated; at least one is no constant."""
    kind = type(one) if isinstance(one, Operand) else type(other)
    return select_of(kind, condition, one, other)


def select_of(kind: type[Operand], condition: Any, one: Any, other: Any) -> Any:
    """One of two values of a kind."""
    code = condition.code
    texts = kind.of(code, one), kind.of(code, other)
    return kind(code, code.select(condition.text, *texts, code.vector_type(kind.kind)))


def minimum(one: Any, other: Any) -> Any:
    """The smaller of two values; the first if one of them is nan."""
    return select(other < one, other, one)


def maximum(one: Any, other: Any) -> Any:
    """The larger of two values; the first if one of them is nan."""
    return select(other > one, other, one)


def copysign(size: Any, sign: Real) -> Real:
    """The absolute value of one number with the sign of another."""
    code = sign.code
    return Real(code, code.call_intrinsic("llvm.copysign", Real.of(code, size), sign.text))


def sqrt(x: Real) -> Real:
    """The square root."""
    return Real(x.code, x.code.call_intrinsic("llvm.sqrt", x.text))


def rint(x: Real) -> Real:
    """The nearest integer, as a number."""
    return Real(x.code, x.code.call_intrinsic("llvm.rint", x.text))


def floor(x: Real) -> Int:
    """The largest integer that is not larger."""
    return Real(x.code, x.code.call_intrinsic("llvm.floor", x.text)).to_int


def polynomial(x: Real, coefficients: Sequence[float]) -> Real:
    """The value of Σ c_k x^k by Horner's rule."""
    result: Real = x.code.value(coefficients[-1])
    for coefficient in reversed(coefficients[:-1]):
        result = fma(x, result, coefficient)
    return result
