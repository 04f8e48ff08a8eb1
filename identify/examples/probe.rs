use dynamics_codegen::Library;
use identify::{log::Log, regression::Hold, trace::*};
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let text = std::fs::read_to_string(&args[1]).unwrap();
    let nominal: serde_json::Value = args
        .get(3)
        .map(|p| serde_json::from_str(&std::fs::read_to_string(p).unwrap()).unwrap())
        .unwrap_or_default();
    let plain = dynamics_codegen::compile(&args[1], &text, &Library::builtin())
        .unwrap_or_else(|r| panic!("{r}"));
    let c: Vec<String> = plain
        .model
        .coordinates
        .iter()
        .map(|c| c.name.clone())
        .collect();
    let u: Vec<String> = plain.model.inputs.iter().map(|c| c.name.clone()).collect();
    let log = Log::read(&args[2]).unwrap_or_else(|e| panic!("{e}"));
    let record = log.select(&c, &u).unwrap_or_else(|e| panic!("{e}"));
    for w in &record.warnings {
        println!("warning: {w}");
    }
    let hold = if nominal["input_hold"] == "zoh" {
        Hold::Previous
    } else {
        Hold::Linear
    };
    let start = std::time::Instant::now();
    let mut observed = Observed::new(record, hold).unwrap();
    println!(
        "noise q {:?} v {:?} a {:?} {:.2?}",
        observed.position_sd,
        observed.velocity_sd,
        observed.acceleration_sd,
        start.elapsed()
    );
    let mut d = Dictionary::new(&args[1], &text, &Library::builtin(), &observed.ranges())
        .unwrap_or_else(|r| panic!("{r}"));
    for (k, v) in nominal["nominal"].as_object().into_iter().flatten() {
        if let Some(i) = d
            .machine
            .compiled
            .model
            .parameters
            .iter()
            .position(|p| p.name == *k)
        {
            d.defaults[i] = v.as_f64().unwrap();
        }
    }
    println!(
        "dictionary {} candidates, {} shapes, {:.2?}",
        d.candidates.len(),
        d.by_shape.len(),
        start.elapsed()
    );
    let s = select(&d, &mut observed).unwrap_or_else(|e| panic!("{e}"));
    println!(
        "nominal misfit {:.3} reduced {:.3} noise {:?} {:.2?}",
        s.nominal_misfit,
        s.reduced_misfit,
        s.noise.force_sd.as_slice(),
        start.elapsed()
    );
    for c in s.considered.iter().take(6) {
        println!(
            "  first {:40} gain {:9.1} score {:9.1} held {:9.1}",
            d.candidates[c.candidate].subject.to_string(),
            c.gain,
            c.score,
            c.held_out_gain
        );
    }
    for t in &s.terms {
        let c = &d.candidates[t.candidate];
        println!(
            "TERM {} evidence {:.1} rivals {:?}",
            c.subject,
            t.evidence,
            t.rivals
                .iter()
                .map(|(r, e)| format!("{r} {e:.1}"))
                .collect::<Vec<_>>()
        );
        for &p in &c.parameters {
            let i = s.estimate.parameters.iter().position(|&x| x == p).unwrap();
            println!(
                "    {} = {:.6} ± {:.6}",
                d.machine.compiled.model.parameters[p].name,
                s.values[p],
                s.estimate.covariance[(i, i)].sqrt()
            );
        }
    }
}
