//! The operations of determinants: over floats, machine integers and big integers.

use num_bigint::BigInt;

/// The operations that the determinants use.
pub(super) trait Ring: Clone {
    /// Computes `self + other`.
    fn plus(&self, other: &Self) -> Self;
    /// Computes `self - other`.
    fn minus(&self, other: &Self) -> Self;
    /// Computes `self * other`.
    fn times(&self, other: &Self) -> Self;
}

impl Ring for f64 {
    #[inline]
    fn plus(&self, other: &Self) -> Self {
        self + other
    }
    #[inline]
    fn minus(&self, other: &Self) -> Self {
        self - other
    }
    #[inline]
    fn times(&self, other: &Self) -> Self {
        self * other
    }
}

/// Machine integers. The caller bounds every partial sum by [`bits`], so no operation overflows. Wrapping operations
/// are used only because they need no overflow check.
macro_rules! machine_ring {
    ($($int:ty),*) => {$(
        impl Ring for $int {
            #[inline]
            fn plus(&self, other: &Self) -> Self {
                self.wrapping_add(*other)
            }
            #[inline]
            fn minus(&self, other: &Self) -> Self {
                self.wrapping_sub(*other)
            }
            #[inline]
            fn times(&self, other: &Self) -> Self {
                self.wrapping_mul(*other)
            }
        }
    )*};
}
machine_ring!(i64, i128);

impl Ring for BigInt {
    fn plus(&self, other: &Self) -> Self {
        self + other
    }
    fn minus(&self, other: &Self) -> Self {
        self - other
    }
    fn times(&self, other: &Self) -> Self {
        self * other
    }
}
