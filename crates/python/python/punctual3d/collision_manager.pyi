from typing import Any, Literal, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import TypeAlias

from ._punctual3d import _Surface

_Yes: TypeAlias = Literal[True]
_No: TypeAlias = Literal[False]
_Pair: TypeAlias = tuple[str, str]

class ContactData:
    names: set[str]
    point: NDArray[np.float64]
    normal: NDArray[np.float64]
    @property
    def depth(self) -> float: ...
    def index(self, name: str) -> int: ...

class DistanceData:
    names: set[str]
    distance: float
    def index(self, name: str) -> int: ...
    def point(self, name: str) -> NDArray[np.float64]: ...

class CollisionManager:
    def __init__(self) -> None: ...
    def add_object(self, name: str, mesh: _Surface, transform: ArrayLike | None = None) -> None: ...
    def remove_object(self, name: str) -> None: ...
    def set_transform(self, name: str, transform: ArrayLike) -> None: ...
    @overload
    def in_collision_single(
        self, mesh: _Surface, transform: ArrayLike | None = None, return_names: _No = False, return_data: _No = False
    ) -> bool: ...
    @overload
    def in_collision_single(
        self, mesh: _Surface, transform: ArrayLike | None = None, *, return_names: _Yes, return_data: _No = False
    ) -> tuple[bool, set[str]]: ...
    @overload
    def in_collision_single(
        self, mesh: _Surface, transform: ArrayLike | None = None, return_names: _No = False, *, return_data: _Yes
    ) -> tuple[bool, list[ContactData]]: ...
    @overload
    def in_collision_single(
        self, mesh: _Surface, transform: ArrayLike | None = None, *, return_names: _Yes, return_data: _Yes
    ) -> tuple[bool, set[str], list[ContactData]]: ...
    @overload
    def in_collision_single(
        self, mesh: _Surface, transform: ArrayLike | None = None, return_names: bool = False, return_data: bool = False
    ) -> Any: ...
    @overload
    def in_collision_internal(self, return_names: _No = False, return_data: _No = False) -> bool: ...
    @overload
    def in_collision_internal(self, *, return_names: _Yes, return_data: _No = False) -> tuple[bool, set[_Pair]]: ...
    @overload
    def in_collision_internal(
        self, return_names: _No = False, *, return_data: _Yes
    ) -> tuple[bool, list[ContactData]]: ...
    @overload
    def in_collision_internal(
        self, *, return_names: _Yes, return_data: _Yes
    ) -> tuple[bool, set[_Pair], list[ContactData]]: ...
    @overload
    def in_collision_internal(self, return_names: bool = False, return_data: bool = False) -> Any: ...
    @overload
    def in_collision_other(
        self, other_manager: CollisionManager, return_names: _No = False, return_data: _No = False
    ) -> bool: ...
    @overload
    def in_collision_other(
        self, other_manager: CollisionManager, *, return_names: _Yes, return_data: _No = False
    ) -> tuple[bool, set[_Pair]]: ...
    @overload
    def in_collision_other(
        self, other_manager: CollisionManager, return_names: _No = False, *, return_data: _Yes
    ) -> tuple[bool, list[ContactData]]: ...
    @overload
    def in_collision_other(
        self, other_manager: CollisionManager, *, return_names: _Yes, return_data: _Yes
    ) -> tuple[bool, set[_Pair], list[ContactData]]: ...
    @overload
    def in_collision_other(
        self, other_manager: CollisionManager, return_names: bool = False, return_data: bool = False
    ) -> Any: ...
    @overload
    def min_distance_single(
        self, mesh: _Surface, transform: ArrayLike | None = None, return_name: _No = False, return_data: _No = False
    ) -> float: ...
    @overload
    def min_distance_single(
        self, mesh: _Surface, transform: ArrayLike | None = None, *, return_name: _Yes, return_data: _No = False
    ) -> tuple[float, str | None]: ...
    @overload
    def min_distance_single(
        self, mesh: _Surface, transform: ArrayLike | None = None, return_name: _No = False, *, return_data: _Yes
    ) -> tuple[float, DistanceData | None]: ...
    @overload
    def min_distance_single(
        self, mesh: _Surface, transform: ArrayLike | None = None, *, return_name: _Yes, return_data: _Yes
    ) -> tuple[float, str | None, DistanceData | None]: ...
    @overload
    def min_distance_single(
        self, mesh: _Surface, transform: ArrayLike | None = None, return_name: bool = False, return_data: bool = False
    ) -> Any: ...
    @overload
    def min_distance_internal(
        self, name: str | None = None, return_names: _No = False, return_data: _No = False
    ) -> float: ...
    @overload
    def min_distance_internal(
        self, name: str | None = None, *, return_names: _Yes, return_data: _No = False
    ) -> tuple[float, _Pair | None]: ...
    @overload
    def min_distance_internal(
        self, name: str | None = None, return_names: _No = False, *, return_data: _Yes
    ) -> tuple[float, DistanceData | None]: ...
    @overload
    def min_distance_internal(
        self, name: str | None = None, *, return_names: _Yes, return_data: _Yes
    ) -> tuple[float, _Pair | None, DistanceData | None]: ...
    @overload
    def min_distance_internal(
        self, name: str | None = None, return_names: bool = False, return_data: bool = False
    ) -> Any: ...
    @overload
    def min_distance_other(
        self, other_manager: CollisionManager, return_names: _No = False, return_data: _No = False
    ) -> float: ...
    @overload
    def min_distance_other(
        self, other_manager: CollisionManager, *, return_names: _Yes, return_data: _No = False
    ) -> tuple[float, _Pair | None]: ...
    @overload
    def min_distance_other(
        self, other_manager: CollisionManager, return_names: _No = False, *, return_data: _Yes
    ) -> tuple[float, DistanceData | None]: ...
    @overload
    def min_distance_other(
        self, other_manager: CollisionManager, *, return_names: _Yes, return_data: _Yes
    ) -> tuple[float, _Pair | None, DistanceData | None]: ...
    @overload
    def min_distance_other(
        self, other_manager: CollisionManager, return_names: bool = False, return_data: bool = False
    ) -> Any: ...
