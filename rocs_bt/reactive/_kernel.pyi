"""Compiled table machine, `_kernel.c`; absent if rocs_bt was installed without a C compiler."""

from typing import final

from numpy import bool_, float64, int32, int64, uint8
from numpy.typing import NDArray

OPERATIONS: int

@final
class Table:
    def __new__(
        cls,
        code: NDArray[int32],
        registers: NDArray[float64],
        initial: NDArray[float64],
        when: NDArray[int32],
        until: NDArray[int32],
        margins: NDArray[int32],
        hold: NDArray[float64],
        cooldown: NDArray[float64],
        max_hold: NDArray[float64],
        level: NDArray[uint8],
        on_invalid: NDArray[uint8],
        priority: NDArray[int64],
        /,
    ) -> Table: ...
    def machine(self, values: NDArray[float64], /) -> Machine: ...
    def batch(
        self,
        x: NDArray[float64],
        t: NDArray[float64],
        values: NDArray[float64],
        winner: NDArray[int32],
        mask: NDArray[bool_],
        margin: NDArray[float64],
        /,
    ) -> None: ...

@final
class Machine:
    def step(self, x: NDArray[float64], t: float, /) -> int: ...
    def wake(self) -> None: ...
    def register(self, index: int, /) -> float: ...
