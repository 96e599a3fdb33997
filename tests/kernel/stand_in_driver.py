"""The functions of NVIDIA's driver that linkages calls, on this processor: for tests without one.

Memory is this process's; a kernel is its function for one state, called for thread after thread.
"""

import ctypes

import numpy as np


class StandIn:
    """As `linkages.kernel.code.cuda` sees the driver's library.

    Parameters
    ----------
    code
        Machine code of `linkages.kernel.code.ptx.lane_functions`.
    arguments
        Kernel → number of its arguments.
    """

    def __init__(self, code, arguments):
        self._code, self._arguments = code, arguments
        self._kernels = list(arguments)
        self.memory = {}
        self.contexts = 0

    def cuInit(self, flags):  # noqa: N802
        return flags.value

    def cuDeviceGet(self, device, index):  # noqa: N802
        device._obj.value = 7 + index.value
        return 0

    def cuCtxCreate_v2(self, context, flags, device):  # noqa: N802
        assert (flags.value, device.value) == (0, 7)
        self.contexts += 1
        context._obj.value = 11
        return 0

    def cuCtxDestroy_v2(self, context):  # noqa: N802
        assert context.value == 11
        self.contexts -= 1
        return 0

    def cuModuleLoadData(self, module, text):  # noqa: N802
        if not text.value.startswith(b"//"):
            return 218
        module._obj.value = 13
        return 0

    def cuModuleGetFunction(self, function, module, name):  # noqa: N802
        assert module.value == 13
        function._obj.value = 1 + self._kernels.index(name.value.decode())
        return 0

    def cuMemAlloc_v2(self, address, size):  # noqa: N802
        room = np.zeros(size.value, dtype=np.uint8)
        address._obj.value = room.ctypes.data
        self.memory[room.ctypes.data] = room
        return 0

    def cuMemFree_v2(self, address):  # noqa: N802
        del self.memory[address.value]
        return 0

    def cuMemcpyHtoD_v2(self, to, source, size):  # noqa: N802
        assert size.value <= self.memory[to.value].nbytes
        ctypes.memmove(to.value, source.value, size.value)
        return 0

    def cuMemcpyDtoH_v2(self, to, source, size):  # noqa: N802
        assert size.value <= self.memory[source.value].nbytes
        ctypes.memmove(to.value, source.value, size.value)
        return 0

    def cuLaunchKernel(self, function, *rest):  # noqa: N802
        *sizes, stream, arguments, extra = rest
        grid, gy, gz, block, by, bz, shared = (size.value for size in sizes)
        assert (gy, gz, by, bz, shared, stream, extra) == (1, 1, 1, 1, 0, None, None)
        name = self._kernels[function.value - 1]
        count = self._arguments[name]
        values = [ctypes.c_uint64.from_address(arguments[k]).value for k in range(count)]
        run = self._code.function(name.removesuffix("s"))
        assert grid * block >= values[-1]
        for thread in range(min(grid * block, values[-1])):
            run(*values[:-1], thread)
        return 0

    def cuGetErrorString(self, status, text):  # noqa: N802
        text._obj.value = b"a PTX JIT compilation failed" if status.value == 218 else b"?"
        return 0
