//! The log under construction.

use crate::mistake::Mistake;
use crate::noise;
use crate::whole_file::WholeFile;
use dynamics_codegen::Model;
use dynamics_codegen::model::AXES;
use std::path::Path;

/// Writes rows; the file is there whole or not at all.
pub struct Recorder {
    file: WholeFile,
}

impl Recorder {
    /// Begins a log of a model with its heading; `impulses` says whether contacts have columns.
    ///
    /// # Errors
    /// If the file cannot be written, or a name cannot stand in a heading.
    pub fn create(path: &Path, model: &Model, impulses: bool) -> anyhow::Result<Self> {
        let mut recorder = Self {
            file: WholeFile::create(path)?,
        };
        recorder.header(model, impulses)?;
        Ok(recorder)
    }

    fn header(&mut self, model: &Model, impulses: bool) -> anyhow::Result<()> {
        let sensors = model.sensors.iter().map(|sensor| sensor.name.clone());
        let impulses = match impulses {
            true => impulse_columns(model),
            false => Vec::new(),
        };
        let names = noise::columns(model).into_iter().chain(sensors);
        let names: Vec<String> = names.chain(impulses).collect();
        if let Some(twice) = (1..names.len()).find(|&i| names[..i].contains(&names[i])) {
            let message = format!("the log would have two columns `{}`", names[twice]);
            return Err(Mistake::new(message)
                .help("rename the sensor or the contact")
                .into());
        }
        if let Some(name) = names.iter().find(|name| name.trim() != name.as_str()) {
            let message =
                format!("a log cannot have a column `{name}`: spaces at its end are lost");
            return Err(Mistake::new(message)
                .help("rename the coordinate, input or sensor")
                .into());
        }
        let names = std::iter::once("t").chain(names.iter().map(String::as_str));
        // A reader counts what else may stand between cells: in a name it stands in quotes.
        let is_odd = names.clone().any(|name| name.contains([';', '\t']));
        let mut line = csv::WriterBuilder::new()
            .quote_style(match is_odd {
                true => csv::QuoteStyle::NonNumeric,
                false => csv::QuoteStyle::Necessary,
            })
            .from_writer(Vec::new());
        line.write_record(names)?;
        Ok(self.file.write_all(&line.into_inner()?)?)
    }

    /// One row.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn row(&mut self, t: f64, values: &[f64]) -> anyhow::Result<()> {
        write!(self.file, "{t:?}")?;
        for value in values {
            write!(self.file, ",{value:?}")?;
        }
        Ok(writeln!(self.file)?)
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(self) -> anyhow::Result<()> {
        Ok(self.file.finish()?)
    }
}

/// Columns of the contacts' impulses: along each plane's axes, then its normal.
fn impulse_columns(model: &Model) -> Vec<String> {
    let contacts = model.contacts.iter();
    let columns = contacts.flat_map(|contact| {
        let axes = contact.plane.axes();
        axes.map(|axis| format!("impulse_{}_{}", contact.name, AXES[axis]))
    });
    columns.collect()
}
