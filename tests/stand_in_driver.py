"""The functions of NVIDIA's driver that linkages calls, on this processor: for tests without one.

Memory is this process's; code is compiled for this processor from what PTX is made of; a kernel is
its function for one thread, called for thread after thread.

On a machine with a graphics processor the same tests run on it, see `Hardware`.
"""

import ctypes
import re
from collections import Counter
from types import SimpleNamespace

import numpy as np

from linkages.kernel.code import cuda
from linkages.kernel.code import cuda as ptx
from linkages.kernel.code.cuda import link
from linkages.kernel.code.machine import MachineCode
from linkages.solvers import device_steps as device

REFUSALS = {
    2: b"out of memory",
    218: b"a PTX JIT compilation failed",
    700: b"an illegal memory access was encountered",
}
HEAD = "; for this processor\n"
KERNEL = re.compile(r"^define ptx_kernel .*?^}$", re.M | re.S)
REGISTER = re.compile(r"^declare i32 @llvm\.nvvm\..*$", re.M)


def assemble(texts, architecture="sm_80"):
    """In place of `linkages.kernel.code.cuda.assemble_ptx`: the code without the kernels."""
    assert re.fullmatch(r"sm_\d\d", architecture)
    plain = [REGISTER.sub("", KERNEL.sub("", text)) for text in texts]
    return HEAD + str(link(plain))


def _there_is_a_device():
    try:
        cuda.Device().close()
    except cuda.DeviceError:
        return False
    return True


THERE = _there_is_a_device()


def installed(monkeypatch, **properties):
    """Have linkages find a stand-in in place of the driver, or this machine's where it has one."""
    driver = (Hardware if THERE else StandIn)(**properties)
    monkeypatch.setattr(cuda, "_driver", lambda: driver)
    if not THERE:
        for module in (ptx, device):
            monkeypatch.setattr(module, "assemble_ptx", assemble)
    return driver


class StandIn:
    """As `linkages.kernel.code.cuda` sees the driver's library.

    Parameters
    ----------
    multiprocessors, free, capability
        What the processor reports; the memory in bytes.

    Attributes
    ----------
    calls
        How often each function was called.
    refuse
        Function → number of the call that fails, and its status.
    """

    def __init__(self, multiprocessors=2, free=1 << 28, capability=(9, 0), devices=1):
        self.attributes = {16: multiprocessors, 39: 2048, 75: capability[0], 76: capability[1]}
        self.free, self.devices = free, devices
        self.memory, self.codes, self.functions = {}, [], []
        self.contexts = 0
        self.calls, self.refuse = Counter(), {}

    def _status(self, name):
        self.calls[name] += 1
        number, status = self.refuse.get(name, (0, 0))
        return status if self.calls[name] == number else 0

    def cuInit(self, flags):  # noqa: N802
        return flags.value

    def cuDeviceGetCount(self, count):  # noqa: N802
        count._obj.value = self.devices
        return 0

    def cuDeviceGet(self, device, index):  # noqa: N802
        device._obj.value = 7 + index.value
        return 0

    def cuDeviceGetName(self, name, size, device):  # noqa: N802
        assert (size.value, device.value) == (len(name), 7)
        name.value = b"Stand-in"
        return 0

    def cuDeviceGetAttribute(self, found, attribute, device):  # noqa: N802
        assert device.value == 7
        found._obj.value = self.attributes[attribute.value]
        return 0

    def cuCtxCreate_v2(self, context, flags, device):  # noqa: N802
        assert (flags.value, device.value) == (4, 7)
        self.contexts += 1
        context._obj.value = 11
        return 0

    def cuCtxSetCurrent(self, context):  # noqa: N802
        assert context.value == 11
        assert self.contexts
        return 0

    def cuCtxDestroy_v2(self, context):  # noqa: N802
        assert context.value == 11
        self.contexts -= 1
        self.memory.clear()
        return 0

    def cuModuleLoadDataEx(self, module, text, count, options, values):  # noqa: N802
        assert (count.value, list(options)) == (2, [5, 6])
        given = text.value.decode()
        if not given.startswith(HEAD):
            said = b"ptxas fatal: syntax error"
            ctypes.memmove(values[0], said + b"\0", min(len(said) + 1, values[1]))
            return 218
        self.codes.append(MachineCode(given))
        module._obj.value = len(self.codes)
        return 0

    def cuModuleGetFunction(self, function, module, name):  # noqa: N802
        self.functions.append((self.codes[module.value - 1], name.value.decode().removesuffix("s")))
        function._obj.value = len(self.functions)
        return 0

    def cuFuncGetAttribute(self, found, attribute, function):  # noqa: N802
        assert function.value
        found._obj.value = {3: 128, 4: 200}[attribute.value]
        return 0

    def cuOccupancyMaxActiveBlocksPerMultiprocessor(  # noqa: N802
        self, blocks, function, threads, shared
    ):
        assert function.value
        assert (threads.value, shared.value) == (64, 0)
        blocks._obj.value = 1
        return 0

    def cuMemGetInfo_v2(self, free, whole):  # noqa: N802
        free._obj.value = self.free - sum(room.nbytes for room in self.memory.values())
        whole._obj.value = self.free
        return 0

    def cuMemAlloc_v2(self, address, size):  # noqa: N802
        status = self._status("cuMemAlloc_v2")
        if not status:
            # what stands in new memory is unknown
            room = np.full(-(-size.value // 8), np.nan).view(np.uint8)
            address._obj.value = room.ctypes.data
            self.memory[room.ctypes.data] = room
        return status

    def cuMemFree_v2(self, address):  # noqa: N802
        del self.memory[address.value]
        return 0

    def _require_room(self, address, size):
        rooms = self.memory.items()
        assert any(first <= address and address + size <= first + r.nbytes for first, r in rooms)

    def cuMemcpyHtoD_v2(self, to, source, size):  # noqa: N802
        self._require_room(to.value, size.value)
        ctypes.memmove(to.value, source.value, size.value)
        return 0

    def cuMemcpyDtoH_v2(self, to, source, size):  # noqa: N802
        self._require_room(source.value, size.value)
        ctypes.memmove(to.value, source.value, size.value)
        return 0

    def cuLaunchKernel(self, function, *rest):  # noqa: N802
        status = self._status("cuLaunchKernel")
        if status:
            return status
        *sizes, stream, arguments, extra = rest
        grid, gy, gz, block, by, bz, shared = (size.value for size in sizes)
        assert (gy, gz, by, bz, shared, stream, extra) == (1, 1, 1, 1, 0, None, None)
        code, name = self.functions[function.value - 1]
        run, count = code.function(name), len(code._types[name]) - 1
        values = [ctypes.c_uint64.from_address(arguments[k]).value for k in range(count)]
        assert grid * block >= values[-1]
        for thread in range(values[-1]):
            run(*values[:-1], thread)
        return 0

    def cuCtxSynchronize(self):  # noqa: N802
        return 0

    def cuGetErrorString(self, status, text):  # noqa: N802
        text._obj.value = REFUSALS.get(status.value, b"?")
        return 0


class Hardware(StandIn):
    """The driver of this machine, whose processor looks as small as a stand-in.

    So motions wait for slots, and calls are counted and refused, as on a stand-in. Memory, code and
    launches are the driver's; new memory is filled with ones, which read as doubles are no numbers.
    """

    def __init__(self, **properties):
        super().__init__(**properties)
        self._library = ctypes.CDLL(cuda._LIBRARY)

    def cuInit(self, flags):  # noqa: N802
        return self._library.cuInit(flags)

    def cuDeviceGet(self, device, index):  # noqa: N802
        return self._library.cuDeviceGet(device, index)

    def cuDeviceGetName(self, name, size, _device):  # noqa: N802
        assert size.value == len(name)
        name.value = b"Stand-in"
        return 0

    def cuDeviceGetAttribute(self, found, attribute, _device):  # noqa: N802
        found._obj.value = self.attributes[attribute.value]
        return 0

    def cuCtxCreate_v2(self, context, flags, device):  # noqa: N802
        self.contexts += 1
        return self._library.cuCtxCreate_v2(context, flags, device)

    def cuCtxSetCurrent(self, context):  # noqa: N802
        assert self.contexts
        return self._library.cuCtxSetCurrent(context)

    def cuCtxDestroy_v2(self, context):  # noqa: N802
        self.contexts -= 1
        self.memory.clear()
        return self._library.cuCtxDestroy_v2(context)

    def cuModuleLoadDataEx(self, module, text, count, options, values):  # noqa: N802
        self.codes.append(text.value)
        return self._library.cuModuleLoadDataEx(module, text, count, options, values)

    def cuModuleGetFunction(self, function, module, name):  # noqa: N802
        return self._library.cuModuleGetFunction(function, module, name)

    def cuMemAlloc_v2(self, address, size):  # noqa: N802
        status = self._status("cuMemAlloc_v2") or self._library.cuMemAlloc_v2(address, size)
        if not status:
            place = address._obj.value
            self.memory[place] = SimpleNamespace(nbytes=size.value)
            status = self._library.cuMemsetD8_v2(ctypes.c_uint64(place), ctypes.c_ubyte(255), size)
        return status

    def cuMemFree_v2(self, address):  # noqa: N802
        del self.memory[address.value]
        return self._library.cuMemFree_v2(address)

    def cuMemcpyHtoD_v2(self, to, source, size):  # noqa: N802
        self._require_room(to.value, size.value)
        return self._library.cuMemcpyHtoD_v2(to, source, size)

    def cuMemcpyDtoH_v2(self, to, source, size):  # noqa: N802
        self._require_room(source.value, size.value)
        return self._library.cuMemcpyDtoH_v2(to, source, size)

    def cuLaunchKernel(self, function, *rest):  # noqa: N802
        status = self._status("cuLaunchKernel")
        if not status:
            status = self._library.cuLaunchKernel(function, *rest)
        return status

    def cuCtxSynchronize(self):  # noqa: N802
        return self._library.cuCtxSynchronize()

    def cuGetErrorString(self, status, text):  # noqa: N802
        return self._library.cuGetErrorString(status, text)
