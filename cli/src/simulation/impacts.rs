//! The list of impacts that `simulate --impacts` writes.

use crate::whole_file::WholeFile;
use dynamics_codegen::Model;
use identify::machine::Impact;
use std::path::Path;

/// Writes impacts; the file is there whole or not at all.
pub struct ImpactList {
    file: WholeFile,
}

impl ImpactList {
    /// Begins a list with its heading.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn create(path: &Path) -> anyhow::Result<Self> {
        let mut file = WholeFile::create(path)?;
        writeln!(file, "t,contact,approach,impulse_x,impulse_y,impulse_z")?;
        Ok(Self { file })
    }

    /// Adds impacts of the contacts of `model`, with impulses along the axes of the planes' frames.
    ///
    /// # Errors
    /// If they cannot be written.
    pub fn add(&mut self, model: &Model, impacts: &[Impact]) -> anyhow::Result<()> {
        for impact in impacts {
            let contact = &model.contacts[impact.contact];
            let mut impulse = [0.0; 3];
            let axes = contact.plane.axes().into_iter();
            axes.zip(impact.impulse)
                .for_each(|(axis, p)| impulse[axis] = p);
            let [x, y, z] = impulse;
            let (t, name, approach) = (impact.t, &contact.name, impact.approach);
            writeln!(self.file, "{t:?},{name},{approach:?},{x:?},{y:?},{z:?}")?;
        }
        Ok(())
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(self) -> anyhow::Result<()> {
        Ok(self.file.finish()?)
    }
}
