//! Traces a log and prints the outcome as JSON: `probe MODEL TRAIN [NOMINAL] [TEST] [HORIZON]`.
use dynamics_codegen::Library;
use identify::log::Log;
use identify::trace::{Request, trace};

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let text = std::fs::read_to_string(&args[1]).unwrap();
    let mut parameters = std::collections::BTreeMap::new();
    if let Some(p) = args.get(3).filter(|p| *p != "-") {
        let nominal: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(p).unwrap()).unwrap();
        for (k, v) in nominal["nominal"].as_object().unwrap() {
            if text.contains(&format!("parameter {k}:")) {
                parameters.insert(k.clone(), v.as_f64().unwrap());
            }
        }
    }
    let train = Log::read(&args[2]).unwrap_or_else(|e| panic!("{e}"));
    let test = args
        .get(4)
        .filter(|p| *p != "-")
        .map(|p| Log::read(p).unwrap());
    let horizon = args.get(5).map_or(0.5, |h| h.parse().unwrap());
    let library = Library::builtin();
    let start = std::time::Instant::now();
    let outcome = trace(&Request {
        model_name: &args[1],
        model_text: &text,
        library: &library,
        parameters,
        train: &train,
        test: test.as_ref(),
        hold: None,
        horizon,
        seed: 1,
    })
    .unwrap_or_else(|e| panic!("{e}"));
    println!("{}", serde_json::to_string_pretty(&outcome).unwrap());
    eprintln!("{:.2?}", start.elapsed());
}
