//! The machine that compiles: no instructions are counted.

/// What is needed of a machine.
pub trait Target {
    /// Runs, and says how many instructions it took.
    fn cost<R>(&mut self, work: impl FnOnce() -> R) -> (u32, R);
    /// A line with a name, a cost and the bits of the results.
    fn print(&mut self, name: &str, cost: u32, results: &[f32]);
}

struct Host;

impl Target for Host {
    fn cost<R>(&mut self, work: impl FnOnce() -> R) -> (u32, R) {
        (0, work())
    }

    fn print(&mut self, name: &str, cost: u32, results: &[f32]) {
        print!("{name} cost {cost}");
        for result in results {
            print!(" {:08x}", result.to_bits());
        }
        println!();
    }
}

/// Everything.
pub fn main() {
    crate::replay::run(&mut Host);
}
