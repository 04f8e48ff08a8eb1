//! What is large is worked through, or refused with a way out, before it takes a minute and 2 GB.

use crate::support::{self, refuse, succeed};
use integration_tests::swing::{ROD, swing};
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions};
use parquet::data_type::DoubleType;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::Arc;
use tempfile::TempDir;

/// A million samples of a rod with viscous friction, in a folder of their own.
fn a_million_samples() -> (TempDir, [String; 2]) {
    let folder = tempfile::tempdir().unwrap();
    let paths = ["arm.urdf", "log.csv"].map(|name| folder.path().join(name));
    fs::write(&paths[0], ROD).unwrap();
    fs::write(
        &paths[1],
        format!("t,q_j,u_j\n{}", swing(1000, 0, 1_000_000)),
    )
    .unwrap();
    (folder, paths.map(|path| path.to_str().unwrap().to_string()))
}

#[test]
fn a_million_samples_are_fitted() {
    if left_out::too_slow() {
        return;
    }
    let (_folder, [arm, log]) = a_million_samples();
    let (said, _) = succeed(&["fit", &arm, &log], "");
    assert!(
        said.starts_with("learnt from 666") && said.contains("friction(j)"),
        "{said}"
    );
}

/// By stretches of it.
#[test]
fn a_million_samples_are_traced() {
    if left_out::too_slow() {
        return;
    }
    let (_folder, [arm, log]) = a_million_samples();
    let (said, warned) = succeed(&["trace", &arm, &log], "");
    assert!(
        warned.contains("samples 100000 are used, in 20 stretches"),
        "{warned}"
    );
    assert!(
        said.contains("viscous (j)") && said.contains("Learnt from 100000 samples"),
        "{said}"
    );
}

/// All functions of a chain of sixty links are less code than a compiler refuses; of one twice as long,
/// some are generated and not all.
#[test]
fn of_a_very_long_chain_some_functions_are_generated_and_not_all() {
    let folder = tempfile::tempdir().unwrap();
    let chain = folder.path().join("chain.urdf");
    let out = folder.path().join("out");
    let generate = |functions: &'static str| -> Vec<&str> {
        let [chain, out] = [&chain, &out].map(|path| path.to_str().unwrap());
        vec![
            "generate",
            chain,
            "--to",
            "c",
            "--functions",
            functions,
            "--out",
            out,
        ]
    };
    fs::write(&chain, support::chain(60)).unwrap();
    succeed(&generate("full"), "");
    let files = fs::read_dir(&out).unwrap();
    let sizes = files.map(|file| file.unwrap().metadata().unwrap().len());
    let size: u64 = sizes.sum();
    assert!(size < 13_000_000, "{size} bytes");
    fs::remove_dir_all(&out).unwrap();
    fs::write(&chain, support::chain(130)).unwrap();
    let said = refuse(&generate("full"), "");
    assert!(said.contains("more than 1000000 operations"), "{said}");
    assert!(!out.exists());
    // What the message proposes.
    assert!(
        said.contains("`--functions inverse_dynamics,forward_dynamics`"),
        "{said}"
    );
    succeed(&generate("inverse_dynamics,forward_dynamics"), "");
    assert_eq!(fs::read_dir(&out).unwrap().count(), 2);
}

/// Rows of noughts, which take next to no room in the file: more cells than there is room for.
fn rows_of_noughts(path: &Path) {
    let schema = "message log { REQUIRED DOUBLE t; REQUIRED DOUBLE q_j; }";
    let schema = Arc::new(parse_message_type(schema).unwrap());
    let properties = Arc::new(WriterProperties::builder().build());
    let file = fs::File::create(path).unwrap();
    let mut writer = SerializedFileWriter::new(file, schema, properties).unwrap();
    let noughts = vec![0.0; 1 << 20];
    for _ in 0..17 {
        let mut rows = writer.next_row_group().unwrap();
        while let Some(mut column) = rows.next_column().unwrap() {
            let values = column.typed::<DoubleType>();
            values.write_batch(&noughts, None, None).unwrap();
            column.close().unwrap();
        }
        rows.close().unwrap();
    }
    writer.close().unwrap();
}

/// One message of 300 MiB of spaces, in a chunk of some kilobytes.
fn message_of_spaces(path: &Path) {
    let file = std::io::BufWriter::new(fs::File::create(path).unwrap());
    let options = WriteOptions::new()
        .compression(Some(Compression::Zstd))
        .chunk_size(None);
    let mut writer = options.create(file).unwrap();
    let channel_id = writer
        .add_channel(0, "/joint_states", "json", &BTreeMap::new())
        .unwrap();
    let header = MessageHeader {
        channel_id,
        sequence: 0,
        log_time: 0,
        publish_time: 0,
    };
    writer
        .write_to_known_channel(&header, &vec![b' '; 300 << 20])
        .unwrap();
    writer.finish().unwrap();
}

/// Small files that stand for more than there is room for are refused as bad input, unread.
#[test]
fn small_files_that_unpack_to_huge_ones() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |name: &str, write: fn(&Path)| {
        let path = folder.path().join(name);
        write(&path);
        let size = fs::metadata(&path).unwrap().len();
        assert!(size < 1 << 20, "{name} has {size} bytes");
        let said = refuse(
            &["trace", "models/pendulum.model", path.to_str().unwrap()],
            "",
        );
        said.replace(folder.path().to_str().unwrap(), "FOLDER")
    };
    let said = [
        refused("noughts.parquet", rows_of_noughts),
        refused("spaces.mcap", message_of_spaces),
    ];
    insta::assert_snapshot!(said.join("\n"));
}
