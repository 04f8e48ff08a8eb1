//! Alignment, both ends first, and definitions that cannot be read.

use super::super::table::Cell;
use super::super::topics::Topic;
use super::*;

/// What stands in a message, by path.
fn read(definition: &Definition, bytes: &[u8]) -> Result<Vec<(String, f64)>, String> {
    let mut topic = Topic::new("x", true);
    topic.begin();
    definition.read(bytes, &mut topic)?;
    topic.end(0);
    let names = topic.names(true).into_iter();
    let found = names.map(|(name, column)| match topic.cell(0, column) {
        Cell::Number(value) => (name, value),
        other => panic!("{name}: {other:?}"),
    });
    Ok(found.collect())
}

const TEXT: &str = "uint8 a\nfloat64 b\nint16[2] c # two\nint32 K=1\nstring<=9 s \"ab\"\nInner[] d\n\
    ================================================================================\n\
    MSG: pkg/msg/Inner\nbool on\nfloat32 x\nEmpty e\n===\nMSG: pkg/Empty\n\n";

/// A message of [`TEXT`], byte for byte.
fn bytes(big: bool, widest: usize) -> Vec<u8> {
    let mut body: Vec<u8> = Vec::new();
    let put = |size: usize, value: u64, body: &mut Vec<u8>| {
        body.resize(body.len().next_multiple_of(size.min(widest)), 0);
        let all = value.to_le_bytes();
        let own = all[..size].iter().copied();
        match big {
            true => body.extend(own.rev()),
            false => body.extend(own),
        }
    };
    put(1, 7, &mut body);
    put(8, 2.5_f64.to_bits(), &mut body);
    put(2, u64::from(-3_i16 as u16), &mut body);
    put(2, 4, &mut body);
    put(4, 3, &mut body);
    body.extend(b"ok\0");
    put(4, 2, &mut body);
    for value in [0.5_f32, -1.5] {
        put(1, 1, &mut body);
        put(4, u64::from(value.to_bits()), &mut body);
        put(1, 0, &mut body);
    }
    let kind = [1 - u8::from(big), 7 - u8::from(big)][usize::from(widest == 4)];
    [&[0, kind, 0, 0], &body[..]].concat()
}

#[test]
fn numbers_stand_at_multiples_of_their_size() {
    let definition = Definition::parse("pkg/msg/Outer", TEXT).unwrap();
    let expected = [
        ("x.a", 7.0),
        ("x.b", 2.5),
        ("x.c.0", -3.0),
        ("x.c.1", 4.0),
        ("x.d.0.on", 1.0),
        ("x.d.0.x", 0.5),
        ("x.d.1.on", 1.0),
        ("x.d.1.x", -1.5),
    ];
    let expected = expected.map(|(name, value)| (name.to_owned(), value));
    for (big, widest) in [(false, 8), (true, 8), (false, 4), (true, 4)] {
        let found = read(&definition, &bytes(big, widest)).unwrap();
        assert_eq!(found, expected, "big: {big}, widest: {widest}");
    }
}

#[test]
fn messages_that_break_off_are_told() {
    let definition = Definition::parse("pkg/Outer", TEXT).unwrap();
    let whole = bytes(false, 8);
    for end in 0..whole.len() {
        let said = read(&definition, &whole[..end]).unwrap_err();
        assert!(said.contains("before its type does"), "{end}: {said}");
    }
    let mut other = whole;
    other[1] = 3;
    insta::assert_snapshot!(read(&definition, &other).unwrap_err(), @"a message of it is in an encoding (00 03) that is no plain CDR");
}

/// A list too long to be joints is stepped over, whatever it is of.
#[test]
fn long_lists_are_stepped_over() {
    let inner = "===\nMSG: p/I\nuint8 x";
    let definition =
        Definition::parse("p/O", &format!("I[] a\nuint16[] b\nuint8 c\n{inner}")).unwrap();
    let mut message = vec![0, 1, 0, 0, 200, 0, 0, 0];
    message.extend([9; 200]);
    message.extend([201, 0, 0, 0]);
    message.extend([8; 402]);
    message.push(5);
    let found = read(&definition, &message).unwrap();
    assert_eq!(found, [("x.c".to_owned(), 5.0)]);
}

#[test]
fn definitions_that_cannot_be_read() {
    let refused = |text: &str| Definition::parse("p/A", text).unwrap_err();
    insta::assert_snapshot!(refused("B b"), @"the file does not define type `p/B`");
    insta::assert_snapshot!(refused("B b\n===\nMSG: p/B\nA a"), @"type `p/A` contains itself");
    insta::assert_snapshot!(refused("float64[0] x"), @"`float64[0] x` in type `p/A` is no field");
    insta::assert_snapshot!(refused("float64"), @"`float64` in type `p/A` is no field");
    insta::assert_snapshot!(refused("wstring s"), @"it has wide text, which middlewares encode differently");
    let deep: String = (0..40)
        .map(|k| format!("T{} x\n===\nMSG: p/T{}\n", k + 1, k + 1))
        .collect();
    insta::assert_snapshot!(refused(&format!("T0 x\n===\nMSG: p/T0\n{deep}")), @"types nest more than 32 deep");
    assert!(Definition::known("my_msgs/Own").is_err());
}
