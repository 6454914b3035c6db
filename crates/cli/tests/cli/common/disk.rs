//! Files and folders on a disk, as programs see them and as they outlast a loss of power.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

/// Files by their paths in a folder.
pub type Files = BTreeMap<PathBuf, Vec<u8>>;

/// What outlasts a loss of power, of the folder a command works in and of the folders below it: `true` where names reach the disk at
/// once, `false` where they do when their folder is synced. The content of a file is what was synced last.
pub const MODELS: [[bool; 2]; 4] = [[true, true], [true, false], [false, true], [false, false]];

enum Node {
    /// Its content as synced last.
    File(String),
    /// Names as they are and as synced last.
    Folder { names: BTreeMap<String, usize>, synced: BTreeMap<String, usize> },
}

/// The disk; node 0 is the folder that a command works in.
pub struct Disk {
    nodes: Vec<Node>,
    root: PathBuf,
}

impl Disk {
    /// Of what is in the folder `root`, all of it on the disk.
    pub fn of(files: &Files, root: &Path) -> Self {
        let mut disk = Self { nodes: vec![empty_folder()], root: root.to_owned() };
        for (path, bytes) in files {
            for folder in path.ancestors().skip(1).collect::<Vec<_>>().into_iter().rev() {
                disk.make(folder);
            }
            let number = disk.add(Node::File(String::from_utf8_lossy(bytes).into_owned()));
            disk.name(path, Some(number));
        }
        for node in &mut disk.nodes {
            if let Node::Folder { names, synced } = node {
                synced.clone_from(names);
            }
        }
        disk
    }

    fn add(&mut self, node: Node) -> usize {
        self.nodes.push(node);
        self.nodes.len() - 1
    }

    /// Path from the root on.
    fn inner<'a>(&self, path: &'a Path) -> &'a Path {
        path.strip_prefix(&self.root).unwrap_or(path)
    }

    fn find(&self, path: &Path) -> Option<usize> {
        let parts = self.inner(path).components().filter_map(|part| match part {
            Component::Normal(name) => name.to_str(),
            _ => None,
        });
        parts.into_iter().try_fold(0, |at, name| match &self.nodes[at] {
            Node::Folder { names, .. } => names.get(name).copied(),
            Node::File(_) => None,
        })
    }

    /// Gives a name to a node, or takes it away: the node that had it.
    fn name(&mut self, path: &Path, number: Option<usize>) -> Option<usize> {
        let path = self.inner(path);
        let (folder, name) = (path.parent()?.to_owned(), path.file_name()?.to_str()?.to_owned());
        let at = self.find(&folder)?;
        let Node::Folder { names, .. } = &mut self.nodes[at] else { return None };
        match number {
            Some(number) => names.insert(name, number),
            None => names.remove(&name),
        }
    }

    fn make(&mut self, path: &Path) {
        if self.find(path).is_none() {
            let number = self.add(empty_folder());
            self.name(path, Some(number));
        }
    }

    /// Takes in a line of the log of `tests/soak/faults.c`.
    pub fn take(&mut self, line: &[String]) {
        let (path, rest) = (Path::new(&line[1]), &line[2..]);
        match line[0].as_str() {
            "open" if rest[0] == "new" => {
                let number = self.add(Node::File(String::new()));
                self.name(path, Some(number));
            }
            "open" if rest[0] == "empty" => {
                let number = self.find(path).unwrap();
                self.nodes[number] = Node::File(String::new());
            }
            "make" => self.make(path),
            "rename" => {
                let number = self.name(path, None);
                self.name(Path::new(&rest[0]), number);
            }
            "link" => {
                let number = self.find(path);
                self.name(Path::new(&rest[0]), number);
            }
            "exchange" => {
                let (first, second) = (self.find(path), self.find(Path::new(&rest[0])));
                self.name(path, second);
                self.name(Path::new(&rest[0]), first);
            }
            "remove" => _ = self.name(path, None),
            "sync" => {
                let number = self.find(path).unwrap();
                match &mut self.nodes[number] {
                    Node::File(content) => content.clone_from(&rest[0]),
                    Node::Folder { names, synced } => synced.clone_from(names),
                }
            }
            _ => {}
        }
    }

    /// Content of a file after a loss of power.
    pub fn content(&self, model: [bool; 2], path: &str) -> Option<&str> {
        self.files(model).into_iter().find(|(place, _)| place == Path::new(path)).map(|(_, content)| content)
    }

    /// Files after a loss of power, but for locks and what a killed writer leaves.
    pub fn files(&self, [is_outer_at_once, are_inner_at_once]: [bool; 2]) -> BTreeMap<PathBuf, &str> {
        let (mut found, mut pending) = (BTreeMap::new(), vec![(PathBuf::new(), 0)]);
        while let Some((path, number)) = pending.pop() {
            match &self.nodes[number] {
                Node::File(content) => _ = found.insert(path, content.as_str()),
                Node::Folder { names, synced } => {
                    let is_at_once = if number == 0 { is_outer_at_once } else { are_inner_at_once };
                    let names = if is_at_once { names } else { synced };
                    let shown = names.iter().filter(|(name, _)| !name.starts_with('.'));
                    pending.extend(shown.map(|(name, number)| (path.join(name), *number)));
                }
            }
        }
        found
    }
}

fn empty_folder() -> Node {
    Node::Folder { names: BTreeMap::new(), synced: BTreeMap::new() }
}
