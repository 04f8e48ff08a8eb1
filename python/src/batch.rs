//! Many states at once: the interpreter free for other threads, all cores if asked to, and an end
//! at Ctrl-C.

use pyo3::prelude::*;
use rayon::prelude::*;
use std::ops::Range;

/// Fewer states than this are not worth letting go of the interpreter.
const FEW: usize = 16;
/// States that one core takes at a time.
const CHUNK: usize = 1024;
/// States after which an interrupt is looked for.
const SLAB: usize = 64 * CHUNK;

/// Fills `out`, `width` numbers per state, by `work` on ranges of states. A range's own part of
/// `out` is handed to it.
///
/// # Errors
/// The first error of `work` by the order of the states, or an interrupt.
pub fn run<E: Send>(
    py: Python<'_>,
    out: &mut [f64],
    width: usize,
    parallel: bool,
    work: impl Fn(Range<usize>, &mut [f64]) -> Result<(), E> + Sync,
    raise: impl Fn(E) -> PyErr,
) -> PyResult<()> {
    if width == 0 || out.is_empty() {
        return Ok(());
    }
    let samples = out.len() / width;
    if samples < FEW {
        return work(0..samples, out).map_err(raise);
    }
    for (number, slab) in out.chunks_mut(SLAB * width).enumerate() {
        let start = number * SLAB;
        let piece = |(k, rows): (usize, &mut [f64])| {
            let first = start + k * CHUNK;
            work(first..first + rows.len() / width, rows)
        };
        let done: Vec<Result<(), E>> = py.detach(|| match parallel {
            true => slab
                .par_chunks_mut(CHUNK * width)
                .enumerate()
                .map(piece)
                .collect(),
            false => slab
                .chunks_mut(CHUNK * width)
                .enumerate()
                .map(piece)
                .collect(),
        });
        done.into_iter()
            .collect::<Result<(), E>>()
            .map_err(&raise)?;
        py.check_signals()?;
    }
    Ok(())
}
