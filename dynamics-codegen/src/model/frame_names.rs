//! Frames by their names, for those who ask where they are.

use super::Model;
use crate::tree::{Layout, Mechanism, Options, Tree, TreeError};
use std::collections::BTreeMap;

impl Model {
    /// The names of frames and bodies, the world's among them, with their indices in
    /// [`tree`](Self::tree). Of several bodies of the tree with one name, the last, which the
    /// others lead to.
    pub fn frames(&self) -> BTreeMap<&str, usize> {
        let bodies = self.tree.bodies.iter().enumerate();
        let mut frames: BTreeMap<&str, usize> = bodies
            .map(|(index, body)| (body.name.as_str(), index))
            .collect();
        let named = self.bodies.iter();
        frames.extend(named.map(|body| (body.name.as_str(), body.frame)));
        frames
    }

    /// The tree with the pose of each of its [`frames`](Self::frames).
    ///
    /// [`mechanism`](Self::mechanism) may not know how far a body has turned that no equation asks
    /// for.
    ///
    /// # Errors
    /// If the bodies do not form a tree, which a compiled model's do.
    pub fn posed(&mut self) -> Result<Mechanism, TreeError> {
        let options = Options {
            layout: Layout::AsGiven,
            regroup: false,
            // What a file rounds has been rounded when it was read.
            snap: None,
        };
        let tree = Tree {
            coordinates: self.coordinates.len(),
            ..self.tree.clone()
        };
        Mechanism::new(&mut self.graph, &tree, options)
    }
}
