//! The linear maps of the constrained equation.

use nalgebra::SMatrix;

/// The maps from `(b, Qbar)` to `(a, λ)` (thesis 3.38–3.43), i.e. the inverse of
/// `K = [[M, Aᵀ], [A, 0]]` by blocks: `a = L b + P Qbar`, `λ = G⁺ b − Lᵀ Qbar`.
///
/// Laws: `T² = T`, `A T = 0`, `P = Pᵀ`, `P Aᵀ = 0`, `P M P = P`, `A L` is the
/// orthogonal projector onto `R(A)` (the identity at full row rank).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projectors<T, const N: usize, const M: usize> {
    /// `L = M⁻¹ Aᵀ G⁺`, n×m: the acceleration that `b` demands.
    pub l: SMatrix<T, N, M>,
    /// `T = I − L A`, n×n: projects accelerations onto `N(A)` along `R(M⁻¹Aᵀ)`.
    pub t: SMatrix<T, N, N>,
    /// `P = T M⁻¹`, n×n, symmetric: from force to acceleration.
    pub p: SMatrix<T, N, N>,
    /// `S = Tᵀ = I − Aᵀ Lᵀ`, n×n: the part of a force that accelerates.
    pub s: SMatrix<T, N, N>,
    /// `G⁺`, m×m, the Moore–Penrose inverse of `G = A M⁻¹ Aᵀ`. Where `M` is singular,
    /// `G` does not exist; this is then the block `∂λ/∂b` all the same.
    pub g_pinv: SMatrix<T, M, M>,
}
