//! Look-up tables: values and derivatives are those of SciPy's splines, and forces that they make
//! are the same whatever they are written in.

use dynamics_codegen::graph::{Graph, SymbolId};
use dynamics_codegen::table::Spline;
use dynamics_codegen::{Compiled, Library, compile, emit};
use serde_json::Value;

fn reference() -> Value {
    serde_json::from_str(include_str!("data/tables.json")).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    let entries = value.as_array().unwrap().iter();
    entries.map(|entry| entry.as_f64().unwrap()).collect()
}

/// Beside the largest number that takes part.
fn near(found: f64, expected: f64, scale: f64, place: &str) {
    let off = (found - expected).abs() / scale.max(expected.abs());
    assert!(off < 1e-11, "{place}: {found} {expected}");
}

#[test]
fn lines_are_those_of_scipy() {
    for line in reference()["lines"].as_array().unwrap() {
        let spline = Spline::through(vec![numbers(&line["points"])], &numbers(&line["values"]));
        let mut graph = Graph::new();
        let symbol = graph.symbol("x");
        let x = graph.var(symbol);
        let value = spline.express(&mut graph, &[x]);
        let slope = graph.derivatives(&[value], symbol)[0];
        let curvature = graph.derivatives(&[slope], symbol)[0];
        let answers = line["answers"].as_array().unwrap();
        for (x, expected) in numbers(&line["at"]).into_iter().zip(answers) {
            let found = graph.evaluate(&[value, slope, curvature], &[x]);
            for (order, (f, e)) in found.iter().zip(numbers(expected)).enumerate() {
                near(*f, e, 10.0, &format!("derivative {order} at {x}"));
            }
        }
    }
}

#[test]
fn grids_are_those_of_scipy() {
    for grid in reference()["grids"].as_array().unwrap() {
        let rows = grid["values"].as_array().unwrap();
        let values: Vec<f64> = rows.iter().flat_map(numbers).collect();
        let spline = Spline::through(vec![numbers(&grid["x"]), numbers(&grid["y"])], &values);
        let mut graph = Graph::new();
        let symbols: [SymbolId; 2] = ["x", "y"].map(|name| graph.symbol(name));
        let arguments = symbols.map(|symbol| graph.var(symbol));
        let value = spline.express(&mut graph, &arguments);
        let [x, y] = symbols.map(|symbol| graph.derivatives(&[value], symbol)[0]);
        let [xx, xy] = symbols.map(|symbol| graph.derivatives(&[x], symbol)[0]);
        let yy = graph.derivatives(&[y], symbols[1])[0];
        let answers = grid["answers"].as_array().unwrap();
        for (at, expected) in grid["at"].as_array().unwrap().iter().zip(answers) {
            let found = graph.evaluate(&[value, x, y, xx, xy, yy], &numbers(at));
            for (order, (f, e)) in found.iter().zip(numbers(expected)).enumerate() {
                near(*f, e, 30.0, &format!("derivative {order} at {at}"));
            }
        }
    }
}

const SLED: &str = "
model sled;
coordinate x: m;
input current: A;
parameter m: kg = 2;
kinetic m/2*dot(x)^2;
table drag(speed: m/s): N { -2: -1.5; -1: -0.4; 0: 0; 1: 0.4; 2: 1.5; }
TABLE
potential height(x)*m*9.81*gravity_unit;
constant gravity_unit: m/s^2 = 1;
table height(x: m): m = \"height.csv\";
force x = thrust(dot(x), current) - drag(dot(x));
";

const INLINE: &str = "table thrust(speed: m/s, current: A): N {
    current: 0, 1, 3;
    0:       0, 2, 5;
    4:       0, 1, 2;
    9:       0, 0, 0.5 + half;
}
constant half = 0.5;";

fn sled(thrust: &str) -> Compiled {
    let mut library = Library::empty();
    library.add_file(
        "height.csv",
        "height.csv",
        "x,height\r\n-1,0.5 # left\n\n0,0\n1;0.5\n2\t2\n",
    );
    let grid = "\u{feff}speed\\current,0,1,3\n0,0,2,5\n4,0,1,2\n9,0,0,1\n";
    library.add_file("thrust.csv", "thrust.csv", grid);
    let compiled = compile("sled.model", &SLED.replace("TABLE", thrust), &library);
    let compiled = compiled.unwrap_or_else(|report| panic!("{report}"));
    assert!(compiled.warnings.diagnostics.is_empty());
    compiled
}

/// In braces or in a file, a table is the same; force, stiffness and damping are continuous.
#[test]
fn a_table_in_a_file_is_one_in_the_text() {
    let inline = sled(INLINE);
    let file = sled("table thrust(speed: m/s, current: A): N = \"thrust.csv\";");
    let tables = &file.model.tables;
    assert_eq!(tables[1].arguments[1].2, [0.0, 1.0, 3.0]);
    assert_eq!(tables[2].arguments[0].2, [-1.0, 0.0, 1.0, 2.0]);
    // The digest is that of the model's own text.
    let code = |compiled: &Compiled| -> Vec<String> {
        let text = emit::rust(compiled, "sled.model");
        let lines = text.lines().filter(|line| !line.contains("Digest:"));
        lines.map(str::to_string).collect()
    };
    assert_eq!(code(&inline), code(&file));
    assert!(emit::review(&file, "sled.model").contains("of current: 3 points, 0 to 3 A"));
    for text in [
        emit::rust(&file, "sled.model"),
        emit::c(&file, "sled.model")[1].text.clone(),
    ] {
        assert!(!text.contains("drag("), "a table is no call");
    }
}

#[test]
fn a_potential_from_a_table_pulls_along_its_slope() {
    let compiled = sled(INLINE);
    let model = &compiled.model;
    let mut symbols = vec![0.0; model.graph.symbol_count()];
    symbols[model.parameters[0].symbol.index()] = 2.0;
    // At a point of the table: height has the slope there that a natural spline has, by hand.
    // Points -1, 0, 1, 2 with heights 0.5, 0, 0.5, 2: 4a + b = 6, a + 4b = 6, slope at 0 is
    // -0.5 + a/3 and a = b = 1.2.
    symbols[model.coordinates[0].position.index()] = 0.0;
    let force = model.graph.evaluate(&compiled.system.bias_force, &symbols)[0];
    let slope = -0.5 + 1.2 / 3.0;
    assert!((force + slope * 2.0 * 9.81).abs() < 1e-12, "{force}");
}

/// Where a table is read the sheet says so, and where its slope enters, of which table.
#[test]
fn review_sheets_name_tables() {
    let text = "\
        model cam;
        coordinate turn: rad;
        coordinate lift: m;
        parameter m: kg = 1;
        parameter inertia: kg*m^2 = 0.1;
        kinetic inertia/2*dot(turn)^2 + m/2*dot(lift)^2;
        table profile(angle: rad): m { 0: 0; 1: 0.01; 2: 0.03; 3: 0.02; }
        constraint follows: lift == 0.5*profile(2*turn);";
    let compiled = compile("cam.model", text, &Library::empty()).unwrap();
    let sheet = emit::review(&compiled, "cam.model");
    for line in [
        "    0 = lift - 0.5*profile(2*turn)",
        "    A[lift] = 1",
        "  profile m",
        "    of angle: 4 points, 0 to 3 rad",
    ] {
        assert!(sheet.lines().any(|l| l == line), "{line}\n{sheet}");
    }
    let row = sheet
        .lines()
        .find(|line| line.starts_with("    A[turn] = "));
    let row = row.unwrap_or_default();
    assert!(
        row.ends_with(" operations, with slopes of `profile`)"),
        "{sheet}"
    );
}
