//! A Cortex-M4F as qemu emulates it (mps2-an386).

use core::hint::black_box;
use core::panic::PanicInfo;
use cortex_m::Peripherals;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_semihosting::{debug, hprint, hprintln};

/// What is needed of a machine.
pub trait Target {
    /// Runs, and says how many instructions it took.
    fn cost<R>(&mut self, work: impl FnOnce() -> R) -> (u32, R);
    /// A line with a name, a cost and the bits of the results.
    fn print(&mut self, name: &str, cost: u32, results: &[f32]);
}

/// The timer of the processor.
struct CortexM4(SYST);

impl CortexM4 {
    fn ticks<R>(&mut self, work: impl FnOnce() -> R) -> (u32, R) {
        self.0.clear_current();
        let before = SYST::get_current();
        let result = black_box(work());
        (before.wrapping_sub(SYST::get_current()) & 0xff_ffff, result)
    }
}

impl Target for CortexM4 {
    /// qemu counts instructions (`-icount shift=10`): one takes 1024 ns, in which the timer of 25 MHz
    /// counts 25.6 down.
    fn cost<R>(&mut self, work: impl FnOnce() -> R) -> (u32, R) {
        let (idle, ()) = self.ticks(|| ());
        let (busy, result) = self.ticks(work);
        (((busy - idle) * 5 + 64) / 128, result)
    }

    fn print(&mut self, name: &str, cost: u32, results: &[f32]) {
        hprint!("{} cost {}", name, cost);
        for result in results {
            hprint!(" {:08x}", result.to_bits());
        }
        hprintln!();
    }
}

#[cortex_m_rt::entry]
fn main() -> ! {
    if let Some(peripherals) = Peripherals::take() {
        let mut timer = peripherals.SYST;
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(0xff_ffff);
        timer.enable_counter();
        crate::replay::run(&mut CortexM4(timer));
        debug::exit(debug::EXIT_SUCCESS);
    }
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    hprintln!("{}", info);
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}
