//! Sums and products of kernels.

use super::Kernel;

impl std::ops::Add for Kernel {
    type Output = Kernel;
    fn add(self, other: Kernel) -> Kernel {
        match self {
            Kernel::Sum(mut parts) => {
                parts.push(other);
                Kernel::Sum(parts)
            }
            first => Kernel::Sum(vec![first, other]),
        }
    }
}

impl std::ops::Mul for Kernel {
    type Output = Kernel;
    fn mul(self, other: Kernel) -> Kernel {
        match self {
            Kernel::Product(mut parts) => {
                parts.push(other);
                Kernel::Product(parts)
            }
            first => Kernel::Product(vec![first, other]),
        }
    }
}
