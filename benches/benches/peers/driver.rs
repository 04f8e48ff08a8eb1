//! Compiled C as a process of its own: no unsafe code here, and no inlining there.

use crate::kernels::{STATES, states};
use std::fmt::Write as _;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// The number type of both sides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// `f64`, `double`
    Double,
    /// `f32`, `float`
    Single,
}

/// CasADi's functions, by file, beside the workspace: near-zero entries of rotations snapped.
const CASADI: [&str; 9] = [
    "M_local_cse",
    "bias_cse",
    "Mbias_cse",
    "fd_ldl_cse",
    "cfd1_cse",
    "drnea_ana_cse",
    "daba_ana_cse",
    "J_cse",
    "JJdot_cse",
];

/// Mass matrix and bias force as CasADi gives them when nothing is rounded: its file here.
pub const UNSNAPPED: &str = "Mbias_unsnapped";

/// A running driver.
pub struct Driver {
    child: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
}

impl Driver {
    /// Compiles CasADi's files and ours, and starts the program.
    ///
    /// # Errors
    /// If a file or the compiler is missing.
    pub fn start(precision: Precision) -> Result<Self, String> {
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        let peers = here.join("../../shared/peers/casadi_iiwa");
        if !peers.is_dir() {
            return Err(format!(
                "{} is not there: CasADi's generated C, with which ours is compared, lies beside the workspace",
                peers.display()
            ));
        }
        let program = compile(&peers, &here.join("benches/peers"), precision)?;
        let mut child = Command::new(&program)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|e| format!("{}: {e}", program.display()))?;
        let (input, output) = (child.stdin.take(), child.stdout.take());
        let (Some(input), Some(output)) = (input, output) else {
            return Err("the driver has no pipes".to_string());
        };
        let output = BufReader::new(output);
        let mut driver = Self {
            child,
            input,
            output,
        };
        let mut text = String::new();
        for state in states::<f64>() {
            for value in state
                .x
                .q
                .iter()
                .chain(&state.x.v)
                .chain(&state.x.u)
                .chain(&state.a)
            {
                let _ = writeln!(text, "{value:?}");
            }
        }
        driver
            .input
            .write_all(text.as_bytes())
            .map_err(|e| e.to_string())?;
        Ok(driver)
    }

    /// Nanoseconds per evaluation over `count` evaluations.
    pub fn time(&mut self, function: &str, count: usize) -> Result<f64, String> {
        let answer = self.ask(&format!("time {function} {count}"))?;
        answer
            .trim()
            .parse()
            .map_err(|e| format!("{function}: {answer:?}: {e}"))
    }

    /// All results at a state.
    pub fn values(&mut self, function: &str, state: usize) -> Result<Vec<f64>, String> {
        assert!(state < STATES);
        let answer = self.ask(&format!("value {function} {state}"))?;
        let numbers = answer.split_whitespace().map(str::parse);
        let numbers: Result<Vec<f64>, _> = numbers.collect();
        numbers.map_err(|e| format!("{function}: {e}"))
    }

    fn ask(&mut self, command: &str) -> Result<String, String> {
        writeln!(self.input, "{command}").map_err(|e| format!("the driver: {e}"))?;
        self.input.flush().map_err(|e| format!("the driver: {e}"))?;
        let mut line = String::new();
        self.output
            .read_line(&mut line)
            .map_err(|e| format!("the driver: {e}"))?;
        if line.is_empty() {
            return Err(format!("the driver ended at `{command}`"));
        }
        Ok(line)
    }
}

impl Drop for Driver {
    fn drop(&mut self) {
        // It ends by itself at the end of its input; nothing is lost if it is gone.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn compile(peers: &Path, here: &Path, precision: Precision) -> Result<PathBuf, String> {
    let out = Path::new(benches::C_FOLDER);
    let name = match precision {
        Precision::Double => "driver_double",
        Precision::Single => "driver_single",
    };
    let program = out.join(name);
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_string());
    let mut command = Command::new(&compiler);
    command.args(["-O3", "-march=native", "-w", "-I"]).arg(out);
    if precision == Precision::Single {
        command.args(["-DDYNAMICS_FLOAT", "-Dcasadi_real=float"]);
    }
    command.arg(here.join("driver.c")).arg(out.join("iiwa7.c"));
    command.args(CASADI.map(|name| peers.join(format!("{name}.c"))));
    command.arg(here.join(format!("unsnapped/{UNSNAPPED}.c")));
    command.arg("-o").arg(&program).arg("-lm");
    let output = command.output().map_err(|e| format!("{compiler}: {e}"))?;
    if output.status.success() {
        Ok(program)
    } else {
        Err(String::from_utf8_lossy(&output.stderr).into_owned())
    }
}
