//! No test: prints what the tests before it have left out. It is a program of its own, since what a
//! test that passes prints is not shown.

fn main() {
    let left_out = left_out::take();
    match left_out.len() {
        0 => println!("\nno test was left out"),
        count => println!("\n{count} tests were LEFT OUT, or parts of them:"),
    }
    for line in &left_out {
        println!("  {line}");
    }
}
