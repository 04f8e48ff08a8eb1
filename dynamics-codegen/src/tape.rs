//! The in-process back end: a list of instructions over blocks of samples.
//!
//! For models that are known only when the program runs. Each instruction works
//! on a block of samples at once, so that the cost of interpreting it is shared,
//! and registers are reused as soon as their last reader has run, so that a
//! block stays in the cache.

use crate::graph::{Binary, ExprId, Graph, Node, SymbolId, Unary};
use std::cell::RefCell;
use std::ops::Range;

/// Samples per block.
const LANES: usize = 64;
/// Lanes are worked on in groups of so many, a vector register or two: a block of few samples costs the groups that
/// it fills, and no more. Values do not depend on it.
const WIDTH: usize = 8;
type Lanes = [f64; LANES];

/// One input of a tape: a value per sample, or one value for all.
#[derive(Debug, Clone, Copy)]
pub enum Column<'a> {
    /// A value per sample.
    Each(&'a [f64]),
    /// The first of every so many values: one entry of rows that lie one behind the other.
    Every(&'a [f64], usize),
    /// The same for all samples.
    Same(f64),
}

impl Column<'_> {
    /// The same input from a later sample on.
    #[must_use]
    pub fn from(self, sample: usize) -> Self {
        match self {
            Self::Each(values) => Self::Each(&values[sample..]),
            Self::Every(values, stride) => Self::Every(&values[sample * stride..], stride),
            Self::Same(value) => Self::Same(value),
        }
    }

    /// Whether there is a value for each of so many samples.
    fn covers(self, samples: usize) -> bool {
        match self {
            Self::Each(values) => values.len() == samples,
            Self::Every(values, stride) => {
                samples == 0 || stride > 0 && values.len() > (samples - 1) * stride
            }
            Self::Same(_) => true,
        }
    }
}

#[derive(Debug, Clone, Copy)]
enum Operation {
    Unary(Unary, u32),
    Binary(Binary, u32, u32),
}

#[derive(Debug, Clone, Copy)]
struct Instruction {
    target: u32,
    operation: Operation,
}

thread_local! {
    /// Registers of whichever tape runs: room that is made anew for each would have to be cleared first.
    static ROOM: RefCell<Vec<Lanes>> = const { RefCell::new(Vec::new()) };
}

/// The registers of one tape, filled with its constants.
#[derive(Debug, Clone)]
pub struct Workspace(Vec<Lanes>);

/// A compiled set of outputs.
#[derive(Debug, Clone)]
pub struct Tape {
    /// Per input: the register it is loaded into, if anything needs it.
    loads: Vec<Option<u32>>,
    constants: Vec<(u32, f64)>,
    instructions: Vec<Instruction>,
    outputs: Vec<u32>,
    registers: usize,
}

impl Tape {
    /// Compiles `outputs` as functions of `inputs`.
    ///
    /// # Panics
    /// If an output depends on a symbol that is not among `inputs`: the caller
    /// lists the symbols of its own model.
    pub fn new(graph: &Graph, outputs: &[ExprId], inputs: &[SymbolId]) -> Self {
        Compiler::new(graph, outputs, inputs).compile(outputs)
    }

    /// How many inputs it takes.
    pub fn input_count(&self) -> usize {
        self.loads.len()
    }

    /// How many outputs it gives.
    pub fn output_count(&self) -> usize {
        self.outputs.len()
    }

    /// How many operations one sample costs.
    pub fn operation_count(&self) -> usize {
        self.instructions.len()
    }

    /// The outputs at one sample.
    pub fn evaluate(&self, inputs: &[f64]) -> Vec<f64> {
        let columns: Vec<Column<'_>> = inputs.iter().map(|&value| Column::Same(value)).collect();
        self.evaluate_all(&columns, 1)
            .into_iter()
            .map(|column| column[0])
            .collect()
    }

    /// The outputs at `samples` samples: one column of that length per output.
    ///
    /// # Panics
    /// If the number of columns, or the length of one, does not fit.
    pub fn evaluate_all(&self, inputs: &[Column<'_>], samples: usize) -> Vec<Vec<f64>> {
        let mut results = vec![vec![0.0; samples]; self.outputs.len()];
        ROOM.with_borrow_mut(|room| {
            if room.len() < self.registers {
                room.resize(self.registers, [0.0; LANES]);
            }
            let registers = &mut room[..self.registers];
            self.fill_constants(registers);
            self.blocks(inputs, samples, registers, |block, registers| {
                for (column, &register) in results.iter_mut().zip(&self.outputs) {
                    column[block.clone()]
                        .copy_from_slice(&registers[register as usize][..block.len()]);
                }
            });
        });
        results
    }

    fn fill_constants(&self, registers: &mut [Lanes]) {
        for &(register, value) in &self.constants {
            registers[register as usize] = [value; LANES];
        }
    }

    /// Room to evaluate in, for [`Tape::evaluate_rows`].
    pub fn workspace(&self) -> Workspace {
        let mut registers: Vec<Lanes> = vec![[0.0; LANES]; self.registers];
        self.fill_constants(&mut registers);
        Workspace(registers)
    }

    /// Writes the outputs at `samples` samples into `rows`: one row of all outputs per sample.
    /// Nothing is allocated.
    ///
    /// # Panics
    /// If the number of columns or rows, or the length of one, does not fit, or the workspace
    /// is another tape's.
    pub fn evaluate_rows(
        &self,
        inputs: &[Column<'_>],
        samples: usize,
        workspace: &mut Workspace,
        rows: &mut [f64],
    ) {
        let width = self.outputs.len();
        assert_eq!(rows.len(), samples * width, "one row per sample");
        self.blocks(inputs, samples, &mut workspace.0, |block, registers| {
            for (place, &register) in self.outputs.iter().enumerate() {
                let lanes = &registers[register as usize];
                for (sample, &value) in block.clone().zip(lanes) {
                    rows[sample * width + place] = value;
                }
            }
        });
    }

    /// Runs block after block and hands over the registers.
    fn blocks(
        &self,
        inputs: &[Column<'_>],
        samples: usize,
        registers: &mut [Lanes],
        mut done: impl FnMut(Range<usize>, &[Lanes]),
    ) {
        assert_eq!(inputs.len(), self.loads.len(), "one column per input");
        assert_eq!(registers.len(), self.registers, "the tape's own workspace");
        for column in inputs {
            assert!(column.covers(samples), "one value per sample");
        }
        for start in (0..samples).step_by(LANES) {
            let count = LANES.min(samples - start);
            let lanes = match count {
                1 => 1,
                _ => count.next_multiple_of(WIDTH),
            };
            self.load(inputs, registers, start..start + count, lanes);
            self.run(registers, lanes);
            done(start..start + count, registers);
        }
    }

    fn load(
        &self,
        inputs: &[Column<'_>],
        registers: &mut [Lanes],
        samples: Range<usize>,
        lanes: usize,
    ) {
        let (start, count) = (samples.start, samples.len());
        for (column, register) in inputs.iter().zip(&self.loads) {
            let Some(register) = register else { continue };
            let lanes = &mut registers[*register as usize][..lanes];
            match column {
                Column::Same(value) => lanes.fill(*value),
                Column::Each(values) => {
                    lanes[..count].copy_from_slice(&values[samples.clone()]);
                }
                Column::Every(values, stride) => {
                    let values = values[start * stride..].iter().step_by(*stride);
                    for (lane, &value) in lanes[..count].iter_mut().zip(values) {
                        *lane = value;
                    }
                }
            }
            // Unused lanes repeat a real sample: they cost no special
            // values, which are slow in some functions.
            let first = lanes[0];
            lanes[count..].fill(first);
        }
    }

    fn run(&self, registers: &mut [Lanes], lanes: usize) {
        for &Instruction { target, operation } in &self.instructions {
            match operation {
                Operation::Unary(op, x) => unary(op, registers, target as usize, x as usize, lanes),
                Operation::Binary(op, x, y) => {
                    binary(
                        op,
                        registers,
                        target as usize,
                        (x as usize, y as usize),
                        lanes,
                    );
                }
            }
        }
    }
}

fn unary(op: Unary, registers: &mut [Lanes], target: usize, x: usize, lanes: usize) {
    let Ok([out, x]) = registers.get_disjoint_mut([target, x]) else {
        unreachable!("a target is never its own operand")
    };
    match op {
        Unary::Neg => map(out, x, lanes, |x| -x),
        op => map(out, x, lanes, |x| op.apply(x)),
    }
}

fn map(out: &mut Lanes, x: &Lanes, lanes: usize, f: impl Fn(f64) -> f64) {
    for (out, &x) in out[..lanes].iter_mut().zip(&x[..lanes]) {
        *out = f(x);
    }
}

fn binary(
    op: Binary,
    registers: &mut [Lanes],
    target: usize,
    (x, y): (usize, usize),
    lanes: usize,
) {
    if x == y {
        let Ok([out, x]) = registers.get_disjoint_mut([target, x]) else {
            unreachable!("a target is never its own operand")
        };
        return match op {
            Binary::Mul => map(out, x, lanes, |x| x * x),
            op => map(out, x, lanes, |x| op.apply(x, x)),
        };
    }
    let Ok([out, x, y]) = registers.get_disjoint_mut([target, x, y]) else {
        unreachable!("a target is never its own operand")
    };
    match op {
        Binary::Add => zip(out, x, y, lanes, |x, y| x + y),
        Binary::Sub => zip(out, x, y, lanes, |x, y| x - y),
        Binary::Mul => zip(out, x, y, lanes, |x, y| x * y),
        Binary::Div => zip(out, x, y, lanes, |x, y| x / y),
        op => zip(out, x, y, lanes, |x, y| op.apply(x, y)),
    }
}

fn zip(out: &mut Lanes, x: &Lanes, y: &Lanes, lanes: usize, f: impl Fn(f64, f64) -> f64) {
    for ((out, &x), &y) in out[..lanes].iter_mut().zip(&x[..lanes]).zip(&y[..lanes]) {
        *out = f(x, y);
    }
}

/// A tape that is evaluated at one sample after the other, without allocation.
#[derive(Debug, Clone)]
pub struct Stepper<'a> {
    tape: &'a Tape,
    /// Inputs that are read, and their registers: of a model's many parameters most are not.
    loads: Vec<(usize, u32)>,
    registers: Vec<Lanes>,
}

impl<'a> Stepper<'a> {
    /// A stepper for `tape`.
    pub fn new(tape: &'a Tape) -> Self {
        let mut registers = vec![[0.0; LANES]; tape.registers];
        for &(register, value) in &tape.constants {
            registers[register as usize][0] = value;
        }
        let loads = tape.loads.iter().enumerate();
        let loads = loads.filter_map(|(input, load)| Some((input, (*load)?)));
        Self {
            tape,
            loads: loads.collect(),
            registers,
        }
    }

    /// Writes the outputs at one sample.
    ///
    /// # Panics
    /// If the number of inputs or outputs does not fit.
    pub fn step(&mut self, inputs: &[f64], outputs: &mut [f64]) {
        assert_eq!(inputs.len(), self.tape.loads.len(), "one value per input");
        assert_eq!(
            outputs.len(),
            self.tape.outputs.len(),
            "one place per output"
        );
        for &(input, register) in &self.loads {
            self.registers[register as usize][0] = inputs[input];
        }
        self.tape.run(&mut self.registers, 1);
        for (value, &register) in outputs.iter_mut().zip(&self.tape.outputs) {
            *value = self.registers[register as usize][0];
        }
    }
}

/// Assigns registers while walking the nodes in order.
struct Compiler<'a> {
    graph: &'a Graph,
    inputs: &'a [SymbolId],
    order: Vec<ExprId>,
    /// Per node: the position in `order` of its last reader.
    last_reader: Vec<usize>,
    register: Vec<Option<u32>>,
    free: Vec<u32>,
    registers: u32,
}

impl<'a> Compiler<'a> {
    fn new(graph: &'a Graph, outputs: &[ExprId], inputs: &'a [SymbolId]) -> Self {
        let order: Vec<ExprId> = graph.reachable(outputs).iter().collect();
        let mut last_reader = vec![0; graph.len()];
        for (position, &expr) in order.iter().enumerate() {
            for child in graph.node(expr).children() {
                last_reader[child.index()] = position;
            }
        }
        for output in outputs {
            last_reader[output.index()] = usize::MAX;
        }
        let register = vec![None; graph.len()];
        Self {
            graph,
            inputs,
            order,
            last_reader,
            register,
            free: Vec::new(),
            registers: 0,
        }
    }

    fn allocate(&mut self) -> u32 {
        self.free.pop().unwrap_or_else(|| {
            self.registers += 1;
            self.registers - 1
        })
    }

    fn compile(mut self, outputs: &[ExprId]) -> Tape {
        let mut loads = vec![None; self.inputs.len()];
        let (mut constants, mut instructions) = (Vec::new(), Vec::new());
        // Inputs and constants keep their registers for the whole run.
        for position in 0..self.order.len() {
            let expr = self.order[position];
            match self.graph.node(expr) {
                Node::Constant(bits) => {
                    let register = self.allocate();
                    constants.push((register, f64::from_bits(bits)));
                    self.register[expr.index()] = Some(register);
                }
                Node::Symbol(symbol) => {
                    let Some(input) = self.inputs.iter().position(|&s| s == symbol) else {
                        panic!(
                            "`{}` is not an input of this tape",
                            self.graph.symbol_name(symbol)
                        )
                    };
                    let register = self.allocate();
                    loads[input] = Some(register);
                    self.register[expr.index()] = Some(register);
                }
                _ => {}
            }
        }
        for position in 0..self.order.len() {
            let expr = self.order[position];
            let node = self.graph.node(expr);
            if !node.is_operation() {
                continue;
            }
            let target = self.allocate();
            let operation = match node {
                Node::Unary(op, x) => Operation::Unary(op, self.register_of(x)),
                Node::Binary(op, x, y) => {
                    Operation::Binary(op, self.register_of(x), self.register_of(y))
                }
                _ => unreachable!("only operations come here"),
            };
            instructions.push(Instruction { target, operation });
            self.register[expr.index()] = Some(target);
            self.release_operands(node, position);
        }
        let outputs = outputs
            .iter()
            .map(|&output| self.register_of(output))
            .collect();
        Tape {
            loads,
            constants,
            instructions,
            outputs,
            registers: self.registers as usize,
        }
    }

    fn register_of(&self, expr: ExprId) -> u32 {
        self.register[expr.index()].expect("children come before parents")
    }

    fn release_operands(&mut self, node: Node, position: usize) {
        let mut previous = None;
        for child in node.children() {
            let reusable = self.graph.node(child).is_operation();
            if reusable && self.last_reader[child.index()] == position && previous != Some(child) {
                let register = self.register_of(child);
                self.free.push(register);
            }
            previous = Some(child);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_graph_over_uneven_blocks() {
        let mut g = Graph::new();
        let (sx, sy) = (g.symbol("x"), g.symbol("y"));
        let (x, y) = (g.var(sx), g.var(sy));
        let sine = g.unary(Unary::Sin, x);
        let product = g.mul(sine, y);
        let square = g.mul(product, product);
        let sum = g.add(square, x);
        let quotient = g.div(sum, y);
        let outputs = [quotient, product, x, sum];
        let tape = Tape::new(&g, &outputs, &[sx, sy]);
        let samples = LANES + 7;
        let values: Vec<f64> = (0..samples).map(|i| 0.1 * i as f64 - 2.0).collect();
        let columns = tape.evaluate_all(&[Column::Each(&values), Column::Same(1.7)], samples);
        for (sample, &x) in values.iter().enumerate() {
            let expected = g.evaluate(&outputs, &[x, 1.7]);
            for (column, value) in columns.iter().zip(expected) {
                assert_eq!(column[sample], value);
            }
        }
        // The room was another tape's in between.
        Tape::new(&g, &[product, sine], &[sx, sy]).evaluate(&[0.7, -3.0]);
        let few = tape.evaluate_all(&[Column::Each(&values[..3]), Column::Same(1.7)], 3);
        for (few, all) in few.iter().zip(&columns) {
            assert_eq!(few[..], all[..3]);
        }
        // The same from rows of three entries, into rows of four.
        let given: Vec<f64> = values.iter().flat_map(|&x| [9.0, x, 8.0]).collect();
        let mut rows = vec![0.0; samples * 4];
        let inputs = [Column::Every(&given[1..], 3), Column::Same(1.7)];
        tape.evaluate_rows(&inputs, samples, &mut tape.workspace(), &mut rows);
        for (sample, row) in rows.chunks(4).enumerate() {
            let expected: Vec<f64> = columns.iter().map(|column| column[sample]).collect();
            assert_eq!(row, expected);
        }
        let (mut stepper, mut found) = (Stepper::new(&tape), [0.0; 4]);
        for x in [-0.4, 0.3] {
            stepper.step(&[x, 1.7], &mut found);
            assert_eq!(found.to_vec(), g.evaluate(&outputs, &[x, 1.7]));
        }
        assert_eq!(
            tape.evaluate(&[0.3, 1.7]),
            g.evaluate(&outputs, &[0.3, 1.7])
        );
    }
}
