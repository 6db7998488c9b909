//! The one door to the processor's wider vectors: AVX2 where there is one, the same instructions four at a time.
//!
//! A kernel is ordinary code over arrays that the compiler turns into vector instructions; behind this door it may use
//! wider ones. Every element is still computed by the same IEEE operations in the same order, so the answer has the
//! same bits on every machine and in the browser (which is compiled for its own 128-bit vectors throughout).

/// A piece of work whose `run` is `#[inline(always)]`, so that it is compiled for the vectors at hand.
pub(crate) trait Kernel {
    /// What it gives.
    type Output;

    /// Does the work.
    fn run(self) -> Self::Output;
}

/// Runs a kernel with the widest vectors of this processor.
#[cfg(target_arch = "x86_64")]
pub(crate) fn widest<K: Kernel>(kernel: K) -> K::Output {
    struct Door<K>(K);
    impl<K: Kernel> pulp::WithSimd for Door<K> {
        type Output = K::Output;

        #[inline(always)]
        fn with_simd<S: pulp::Simd>(self, _simd: S) -> K::Output {
            self.0.run()
        }
    }
    pulp::Arch::new().dispatch(Door(kernel))
}

/// Runs a kernel with the vectors that the crate is compiled for.
#[cfg(not(target_arch = "x86_64"))]
pub(crate) fn widest<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}
