//! The choice of vector instructions at run time: one program for AVX-512, AVX2 and any machine.
//!
//! What is to run on lanes is written once, generic over [`Pack`], and handed to [`run`]. All that
//! it calls for every step has to be `inline(always)`: only what is inlined here is compiled with
//! the instructions chosen.
#![expect(
    unsafe_code,
    reason = "instructions that a machine may lack are unsafe to call"
)]

#[cfg(target_arch = "x86_64")]
mod registers;

use bicycle::lanes::Pack;
use rayon::prelude::*;
use std::sync::LazyLock;

/// Work that runs on any [`Pack`].
pub trait Work {
    /// What comes out.
    type Output;

    /// Does it. To be marked `#[inline(always)]`.
    fn run<T: Pack>(self) -> Self::Output;
}

/// Instructions to choose from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Isa {
    /// Eight doubles in a register; two of them in flight.
    Avx512,
    /// Four doubles in a register; two of them in flight.
    Avx2,
    /// What every processor has: one number at a time.
    Portable,
}

/// What this machine has.
static BEST: LazyLock<Isa> = LazyLock::new(|| {
    let has = |isa: &Isa| isa.is_present();
    Isa::ALL.into_iter().find(has).unwrap_or(Isa::Portable)
});

impl Isa {
    /// All, widest first.
    pub const ALL: [Self; 3] = [Self::Avx512, Self::Avx2, Self::Portable];

    /// The widest that this machine has.
    pub fn best() -> Self {
        *BEST
    }

    /// Whether this machine has it.
    pub fn is_present(self) -> bool {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx2")
                    && is_x86_feature_detected!("fma")
            }
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma"),
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx512 | Self::Avx2 => false,
            Self::Portable => true,
        }
    }

    /// Numbers advanced together: [`Pack::WIDTH`] of what [`run_with`] chooses.
    pub fn lanes(self) -> usize {
        match self {
            Self::Avx512 => 16,
            Self::Avx2 => 8,
            Self::Portable => 1,
        }
    }

    /// The name in tables and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Avx512 => "avx512",
            Self::Avx2 => "avx2",
            Self::Portable => "portable",
        }
    }
}

/// Runs `work` with the widest instructions that this machine has.
pub fn run<W: Work>(work: W) -> W::Output {
    run_with(Isa::best(), work)
}

/// Runs `work` with the instructions of `isa`, or the portable ones where the machine lacks them.
pub fn run_with<W: Work>(isa: Isa, work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
        fn avx512<W: Work>(work: W) -> W::Output {
            work.run::<registers::Avx512>()
        }

        #[target_feature(enable = "avx2,fma")]
        fn avx2<W: Work>(work: W) -> W::Output {
            work.run::<registers::Avx2>()
        }

        if isa.is_present() {
            match isa {
                // SAFETY: `is_present` found every feature that the function is compiled for
                Isa::Avx512 => return unsafe { avx512(work) },
                // SAFETY: as above
                Isa::Avx2 => return unsafe { avx2(work) },
                Isa::Portable => {}
            }
        }
    }
    let _ = isa;
    work.run::<f64>()
}

/// Runs `job` on every chunk of at most [`Isa::lanes`] of `items`, on all cores, results in the
/// order of `items`: the same whatever the number of cores.
pub fn in_batches<I: Sync, O: Send>(
    items: &[I],
    job: impl Fn(&[I]) -> Vec<O> + Sync + Send,
) -> Vec<O> {
    let batches = items.par_chunks(Isa::best().lanes());
    batches.flat_map_iter(job).collect()
}
