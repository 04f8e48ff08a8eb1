"""What is computed for the package, in Rust."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from numpy.typing import ArrayLike

from dynamics._types import Array, File, Recording

class Error(ValueError): ...
class SolveError(Error): ...

class Model:
    @staticmethod
    def load(
        path: File,
        *,
        parameters: Mapping[str, float] | File | None = None,
        effects: Sequence[File] = (),
    ) -> Model: ...
    def with_parameters(self, parameters: Mapping[str, float]) -> Model: ...
    def compile(
        self, *, compiler: str = "cc", options: Sequence[str] = ("-O3", "-march=native")
    ) -> Model: ...
    @property
    def is_compiled(self) -> bool: ...
    @property
    def name(self) -> str: ...
    @property
    def path(self) -> Path: ...
    @property
    def text(self) -> str: ...
    @property
    def positions(self) -> list[str]: ...
    @property
    def coordinates(self) -> list[str]: ...
    @property
    def inputs(self) -> list[str]: ...
    @property
    def states(self) -> list[str]: ...
    @property
    def constraints(self) -> list[str]: ...
    @property
    def frames(self) -> list[str]: ...
    @property
    def output_names(self) -> list[str]: ...
    @property
    def parameters(self) -> dict[str, float]: ...
    @property
    def units(self) -> dict[str, str]: ...
    @property
    def warnings(self) -> list[str]: ...
    def mass_matrix(
        self, q: ArrayLike, *, t: ArrayLike | None = None, parallel: bool = False
    ) -> Array: ...
    def bias_force(
        self,
        q: ArrayLike,
        v: ArrayLike | None = None,
        *,
        t: ArrayLike | None = None,
        parallel: bool = False,
    ) -> Array: ...
    def applied_force(
        self,
        q: ArrayLike,
        v: ArrayLike | None = None,
        *,
        z: ArrayLike | None = None,
        t: ArrayLike | None = None,
        parallel: bool = False,
    ) -> Array: ...
    def input_matrix(
        self,
        q: ArrayLike,
        v: ArrayLike | None = None,
        *,
        z: ArrayLike | None = None,
        t: ArrayLike | None = None,
        parallel: bool = False,
    ) -> Array: ...
    def inverse_dynamics(
        self,
        q: ArrayLike,
        v: ArrayLike,
        a: ArrayLike,
        *,
        z: ArrayLike | None = None,
        t: ArrayLike | None = None,
        parallel: bool = False,
    ) -> Array: ...
    def forward_dynamics(
        self,
        q: ArrayLike,
        v: ArrayLike | None = None,
        u: ArrayLike | None = None,
        *,
        z: ArrayLike | None = None,
        t: ArrayLike | None = None,
        parallel: bool = False,
    ) -> Array: ...
    def multipliers(
        self,
        q: ArrayLike,
        v: ArrayLike | None = None,
        u: ArrayLike | None = None,
        *,
        z: ArrayLike | None = None,
        t: ArrayLike | None = None,
        parallel: bool = False,
    ) -> Array: ...
    def constraint_jacobian(
        self,
        q: ArrayLike,
        v: ArrayLike | None = None,
        *,
        t: ArrayLike | None = None,
        parallel: bool = False,
    ) -> Array: ...
    def constraint_bias(
        self,
        q: ArrayLike,
        v: ArrayLike | None = None,
        *,
        t: ArrayLike | None = None,
        parallel: bool = False,
    ) -> Array: ...
    def constraint_residual(
        self,
        q: ArrayLike,
        v: ArrayLike | None = None,
        *,
        t: ArrayLike | None = None,
        parallel: bool = False,
    ) -> Array: ...
    def constraint_rate(
        self,
        q: ArrayLike,
        v: ArrayLike | None = None,
        *,
        t: ArrayLike | None = None,
        parallel: bool = False,
    ) -> Array: ...
    def state_rates(
        self,
        q: ArrayLike,
        v: ArrayLike | None = None,
        u: ArrayLike | None = None,
        *,
        z: ArrayLike | None = None,
        t: ArrayLike | None = None,
        parallel: bool = False,
    ) -> Array: ...
    def outputs(
        self,
        q: ArrayLike,
        v: ArrayLike | None = None,
        u: ArrayLike | None = None,
        *,
        z: ArrayLike | None = None,
        t: ArrayLike | None = None,
        parallel: bool = False,
    ) -> Array: ...

    def frame_pose(
        self, frame: str, q: ArrayLike, *, t: ArrayLike | None = None, parallel: bool = False
    ) -> Array: ...
    def frame_jacobian(
        self, frame: str, q: ArrayLike, *, t: ArrayLike | None = None, parallel: bool = False
    ) -> Array: ...
    def derivatives(
        self,
        q: ArrayLike,
        v: ArrayLike | None = None,
        u: ArrayLike | None = None,
        *,
        z: ArrayLike | None = None,
        t: ArrayLike | None = None,
        parallel: bool = False,
    ) -> Derivatives: ...
    def simulate(
        self,
        q: ArrayLike,
        v: ArrayLike | None = None,
        u: ArrayLike | None = None,
        *,
        duration: float,
        input_times: ArrayLike | None = None,
        rate: float = 100.0,
        max_step: float = 0.00025,
        z: ArrayLike | None = None,
        t: float = 0.0,
    ) -> Simulation: ...

class Derivatives:
    @property
    def a_q(self) -> Array: ...
    @property
    def a_v(self) -> Array: ...
    @property
    def a_u(self) -> Array: ...
    @property
    def a_parameters(self) -> Array: ...
    @property
    def a_t(self) -> Array: ...
    @property
    def lambda_q(self) -> Array: ...
    @property
    def lambda_v(self) -> Array: ...
    @property
    def lambda_u(self) -> Array: ...
    @property
    def lambda_parameters(self) -> Array: ...
    @property
    def lambda_t(self) -> Array: ...

class Simulation:
    @property
    def t(self) -> Array: ...
    @property
    def q(self) -> Array: ...
    @property
    def v(self) -> Array: ...
    @property
    def a(self) -> Array: ...
    @property
    def u(self) -> Array: ...
    def columns(self) -> dict[str, Array]: ...
    def __len__(self) -> int: ...

class Report:
    json: str
    series: str
    summary: str
    diff: str
    html: str
    text: str
    def apply(self, path: File | None = None) -> bool: ...
    def write(self, folder: File) -> None: ...

def trace(
    model: Model,
    train: list[Recording],
    test: list[Recording],
    map: File | None,
    hold: str | None,
    horizon: float,
    seed: int,
    time_limit: float,
    trust_columns: bool,
    call: str,
) -> Report: ...
def fit(
    model: Model,
    train: list[Recording],
    test: list[Recording],
    map: File | None,
    choices: tuple[str, list[str], bool],
    call: str,
) -> Report: ...

class Learnt:
    log_evidence: float
    noise: list[float]
    signal: list[float]
    lengths: list[list[float]]
    def predict(self, x: Array, names: list[str], quantity: str) -> tuple[Array, Array]: ...

def learn(
    model: Model,
    x: Array,
    y: Array,
    names: list[str],
    columns: list[int],
    points: int,
    restarts: int,
    seed: int,
) -> Learnt: ...
