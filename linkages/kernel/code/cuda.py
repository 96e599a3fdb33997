"""NVIDIA graphics processors: kernels in PTX, and the driver's interface.

LLVM, which comes with llvmlite, writes PTX; NVIDIA's driver makes machine code of it (CUDA Driver
API Reference Manual). Operations carry their rounding (``.rn``), and neither of the two contracts
or reorders them, so bits are those of other processors, as far as IEEE 754 goes.

States stand in blocks of `WIDTH`, the threads of a warp: an array of n entries consists of blocks
of n rows of `WIDTH` numbers, so that threads side by side read numbers side by side.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Sequence
from ctypes import byref, c_char_p, c_int, c_size_t, c_uint, c_uint64, c_void_p
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.errors import LinkagesError
from linkages.kernel.code.instructions import INTEGER, Instructions
from linkages.kernel.code.machine import kept
from linkages.kernel.code.statements import Routine
from linkages.kernel.code.writer import Module, call_routine

THREADS = 64
"""Of a block: few, so that each may have many registers."""

LEAST_CAPABILITY = 6, 0
"""Of processors that LLVM and today's drivers know."""

_LATEST = 8, 0
"""For which code is written at most: processors that came later run it as well."""

_LIBRARY = "nvcuda.dll" if os.name == "nt" else "libcuda.so.1"
_LOG = 8192  # bytes of what the driver says of a text
# numbers of the driver's interface
_SLEEP_WHILE_WAITING = 4
_MULTIPROCESSORS, _RESIDENT, _MAJOR, _MINOR = 16, 39, 75, 76
_LOCAL, _REGISTERS = 3, 4
_ERROR_LOG, _ERROR_LOG_SIZE = 5, 6


class DeviceError(LinkagesError):
    """There is no graphics processor, or it refused something."""


class Device:
    """A graphics processor; a context manager. Any thread may use it, one at a time.

    Raises DeviceError if there is no driver, no processor, or it is too old.
    """

    def __init__(self, number: int = 0) -> None:
        self._context, self._device = c_void_p(), c_int()
        count, name = c_int(), ctypes.create_string_buffer(256)
        _call("cuInit", c_uint(0))
        _call("cuDeviceGetCount", byref(count))
        if not count.value:
            raise DeviceError("the driver knows no graphics processor; expected one of NVIDIA")
        _call("cuDeviceGet", byref(self._device), c_int(number))
        _call("cuDeviceGetName", name, c_int(len(name)), self._device)
        self.name = name.value.decode(errors="replace")
        capability = self._number(_MAJOR), self._number(_MINOR)
        if capability < LEAST_CAPABILITY:
            result, least = (".".join(map(str, c)) for c in (capability, LEAST_CAPABILITY))
            raise DeviceError(f"{self.name} has compute capability {result}; expected {least}")
        major, minor = min(capability, _LATEST)
        self.architecture = f"sm_{major}{minor}"
        self.multiprocessors = self._number(_MULTIPROCESSORS)
        self.resident = self._number(_RESIDENT)
        _call("cuCtxCreate_v2", byref(self._context), c_uint(_SLEEP_WHILE_WAITING), self._device)

    def _number(self, attribute: int) -> int:
        result = c_int()
        _call("cuDeviceGetAttribute", byref(result), c_int(attribute), self._device)
        return result.value

    def __enter__(self) -> Device:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Give back all that it holds."""
        if self._context:
            _call("cuCtxDestroy_v2", self._context)
        self._context = c_void_p()

    @property
    def free(self) -> int:
        """Bytes of its memory that nobody has."""
        free, whole = c_size_t(), c_size_t()
        self._call("cuMemGetInfo_v2", byref(free), byref(whole))
        return free.value

    def load(self, text: str, name: str) -> DeviceKernel:
        """A kernel of a text in PTX; a DeviceError has what the driver says of it."""
        module, function = c_void_p(), c_void_p()
        log = ctypes.create_string_buffer(_LOG)
        options = (c_int * 2)(_ERROR_LOG, _ERROR_LOG_SIZE)
        values = (c_void_p * 2)(ctypes.addressof(log), _LOG)
        code = c_char_p(text.encode())
        try:
            self._call("cuModuleLoadDataEx", byref(module), code, c_uint(2), options, values)
        except DeviceError as error:
            said = log.value.decode(errors="replace").strip()
            raise DeviceError(f"{error}\n{said}".strip()) from None
        self._call("cuModuleGetFunction", byref(function), module, c_char_p(name.encode()))
        return DeviceKernel(self, function)

    def reserve(self, size: int) -> int:
        """Address of so many bytes; `release` gives them back."""
        address = c_uint64()
        self._call("cuMemAlloc_v2", byref(address), c_size_t(max(1, size)))
        return address.value

    def release(self, addresses: Sequence[int]) -> None:
        """Give back memory."""
        for address in addresses:
            self._call("cuMemFree_v2", c_uint64(address))

    def put(self, values: NDArray[Any], address: int) -> None:
        """Copy an array to the processor."""
        values = np.ascontiguousarray(values)
        source, size = c_void_p(values.ctypes.data), c_size_t(values.nbytes)
        self._call("cuMemcpyHtoD_v2", c_uint64(address), source, size)

    def get(self, address: int, into: NDArray[Any]) -> None:
        """Copy an array from the processor, when all kernels have ended."""
        if not into.flags.c_contiguous:
            raise ValueError("expected an array without gaps to copy into")
        target, size = c_void_p(into.ctypes.data), c_size_t(into.nbytes)
        self._call("cuMemcpyDtoH_v2", target, c_uint64(address), size)

    def _call(self, name: str, *arguments: Any) -> None:
        """Call a function of the driver for this processor, which belongs to no thread."""
        _call("cuCtxSetCurrent", self._context)
        _call(name, *arguments)


class DeviceKernel:
    """A kernel that a graphics processor has loaded; `Device.load` makes it.

    `registers` and `local` (bytes) are those of a thread; `threads` run at the same time.
    """

    def __init__(self, device: Device, function: c_void_p) -> None:
        self._device, self._function = device, function
        self.registers, self.local = self._number(_REGISTERS), self._number(_LOCAL)
        blocks = c_int()
        device._call(
            "cuOccupancyMaxActiveBlocksPerMultiprocessor",
            byref(blocks), function, c_int(THREADS), c_size_t(0),
        )  # fmt: skip
        self.threads = device.multiprocessors * blocks.value * THREADS

    def _number(self, attribute: int) -> int:
        result = c_int()
        self._device._call("cuFuncGetAttribute", byref(result), c_int(attribute), self._function)
        return result.value

    def run(self, arguments: Sequence[int], count: int) -> None:
        """Run some threads, and wait for them."""
        given = [*map(c_uint64, arguments), c_uint64(count)]
        pointers = (c_void_p * len(given))(*(ctypes.addressof(value) for value in given))
        # of the grid, of a block, of shared memory
        sizes = (-(-count // THREADS), 1, 1, THREADS, 1, 1, 0)
        call = self._device._call
        call("cuLaunchKernel", self._function, *map(c_uint, sizes), None, pointers, None)
        call("cuCtxSynchronize")


def _call(name: str, *arguments: Any) -> None:
    driver = _driver()
    status = getattr(driver, name)(*arguments)
    if status == 0:
        return
    text = c_char_p()
    driver.cuGetErrorString(c_int(status), byref(text))
    said = (text.value or b"an unknown error").decode()
    raise DeviceError(f"the driver of the graphics processor refused {name} ({status}): {said}")


@cache
def _driver() -> Any:
    try:
        return ctypes.CDLL(_LIBRARY)
    except OSError:
        raise DeviceError(
            f"no driver of an NVIDIA graphics processor was found ({_LIBRARY}); "
            "expected a machine that has one, or a computation on the CPU"
        ) from None


WIDTH = 32
"""Threads of a warp, which read one row of an array together."""

_TRIPLE = "nvptx64-nvidia-cuda"
_REGISTER = "llvm.nvvm.read.ptx.sreg"


class MissingFunctionError(DeviceError):
    """A kernel calls functions that graphics processors have no code for."""

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        super().__init__(
            f"kernels call {', '.join(names)} of the C library, which graphics processors do not "
            "have; expected functions that linkages.kernel.code.elementary_functions writes"
        )


def write_ptx(routines: Sequence[Routine], architecture: str = "sm_80") -> str:
    """The text of a module with a kernel ``NAME_lanes`` for each routine.

    Its arguments are the addresses of all arrays of the routine, also of the times, which are an
    array of one entry; that of one status (int64) per state; and the number of states.
    """
    module = lane_functions(routines)
    for routine in routines:
        add_kernel(module, routine.name, (*routine.arguments, "status"))
    return assemble_ptx([module.text], architecture)


def lane_functions(routines: Sequence[Routine]) -> Module:
    """A module with a function ``NAME_lane`` for each routine, which runs it for one state."""
    arrays = {name for routine in routines for name in routine.arguments}
    module = Module(strides=dict.fromkeys(arrays, WIDTH))
    for routine in routines:
        module.add(routine, internal=True)
        code = module.instructions()
        given = {
            name: code.column(f"%{name}", "%lane", max(1, size), WIDTH)
            for name, size in routine.arguments.items()
        }
        if "t" in given:
            given["t"] = code.load(given["t"], 0)
        status = call_routine(code, routine, given)
        place = code.assign(f"getelementptr {INTEGER}, ptr %status, {INTEGER} %lane")
        code.emit(f"store {INTEGER} {status}, ptr {place}")
        code.emit("ret void")
        module.define(lane_signature(routine.name, (*routine.arguments, "status")), code)
    return module


def lane_signature(name: str, arrays: Sequence[str], integers: Sequence[str] = ()) -> str:
    """Signature of the function that a kernel calls: addresses, integers, number of a state."""
    return f"void @{name}_lane({_arguments(arrays, (*integers, 'lane'))})"


def add_kernel(
    module: Module, name: str, arrays: Sequence[str], integers: Sequence[str] = ()
) -> None:
    """Add the kernel ``NAME_lanes``, whose threads call ``NAME_lane`` for the state of theirs.

    Its last argument is the number of states, in place of the number of one.
    """
    code = module.instructions()
    index = _thread(code)
    run, done = code.new_label("run"), code.new_label("done")
    code.branch(code.assign(f"icmp ult {INTEGER} {index}, %count"), run, done)
    code.begin_block(run)
    code.emit(f"call void @{name}_lane({_arguments(arrays, integers)}, {INTEGER} {index})")
    code.emit(f"br label %{done}")
    code.begin_block(done)
    code.emit("ret void")
    module.define(
        f"ptx_kernel void @{name}_lanes({_arguments(arrays, (*integers, 'count'))})", code
    )


def _arguments(arrays: Sequence[str], integers: Sequence[str]) -> str:
    return ", ".join([*(f"ptr %{a}" for a in arrays), *(f"{INTEGER} %{i}" for i in integers)])


def link(texts: Sequence[str]) -> Any:
    """A module of all functions of some, which may call each other."""
    first, *others = (_llvm().parse_assembly(text) for text in texts)
    for other in others:
        first.link_in(other)
    return first


def assemble_ptx(texts: Sequence[str], architecture: str = "sm_80") -> str:
    """PTX of all functions of some modules, for processors of an architecture and later ones."""
    key = "\n".join([architecture, *map(str, _llvm().llvm_version_info), *texts])
    content, _ = kept(key, ".ptx", lambda: _assembled(texts, architecture).encode())
    return content.decode()


def _assembled(texts: Sequence[str], architecture: str) -> str:
    llvm, module = _llvm(), link(texts)
    missing = [f.name for f in module.functions if f.is_declaration]
    missing = [name for name in missing if not name.startswith("llvm.")]
    if missing:
        raise MissingFunctionError(sorted(missing))
    for function in module.functions:
        if not function.is_declaration and not function.name.endswith("_lanes"):
            function.linkage = "internal"  # a part of the kernels, and of nothing else
    target = llvm.Target.from_triple(_TRIPLE).create_target_machine(cpu=architecture, opt=3)
    module.triple, module.data_layout = _TRIPLE, str(target.target_data)
    builder = llvm.create_pass_builder(target, llvm.create_pipeline_tuning_options(3))
    builder.getModulePassManager().run(module, builder)
    return str(target.emit_assembly(module))


def _thread(code: Instructions) -> str:
    """Number of a thread among all."""
    result = []
    for name in ("ctaid.x", "ntid.x", "tid.x"):
        register = f"{_REGISTER}.{name}"
        code.declared[register] = f"i32 @{register}()"
        number = code.assign(f"call i32 @{register}()")
        result.append(code.assign(f"zext i32 {number} to {INTEGER}"))
    block, size, thread = result
    first = code.assign(f"mul {INTEGER} {block}, {size}")
    return code.assign(f"add {INTEGER} {first}, {thread}")


@cache
def _llvm() -> Any:
    import llvmlite.binding

    llvmlite.binding.initialize_all_targets()
    llvmlite.binding.initialize_all_asmprinters()
    return llvmlite.binding
