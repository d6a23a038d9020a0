//! The folder of a sweep: a manifest and parts. Each part is either complete or absent.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde_json::Value;
use tempfile::NamedTempFile;

use super::error::SweepError;
use crate::temporary::temporary;

/// The prefix and the suffix of the names of temporary files. Readers of Parquet ignore names that begin with
/// a dot.
const TEMPORARY: [&str; 2] = [".dsocs-", ".part"];

/// The folder of a sweep.
#[derive(Clone, Debug)]
pub struct Folder {
    /// Its path.
    path: PathBuf,
}

/// The tables of a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableKind {
    /// A row for each point.
    Points,
    /// A row for each kept node.
    Nodes,
}

impl TableKind {
    /// The name of its folder.
    pub fn name(self) -> &'static str {
        match self {
            Self::Points => "points",
            Self::Nodes => "nodes",
        }
    }
}

impl Folder {
    /// A folder, which need not exist yet.
    pub fn new(path: &Path) -> Self {
        Self {
            path: path.to_owned(),
        }
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The manifest's file.
    pub fn manifest_path(&self) -> PathBuf {
        self.path.join("manifest.json")
    }

    /// The manifest, if there is one.
    ///
    /// # Errors
    ///
    /// [`SweepError::Read`] if it cannot be read or is not a manifest.
    pub fn manifest(&self) -> Result<Option<Value>, SweepError> {
        let path = self.manifest_path();
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(SweepError::read(&path, error)),
        };
        match serde_json::from_str(&text) {
            Ok(manifest) => Ok(Some(manifest)),
            Err(error) => Err(SweepError::read(&path, error)),
        }
    }

    /// Creates the folder with its manifest, unless another process has done so.
    ///
    /// # Errors
    ///
    /// [`SweepError::Write`] if it cannot be written.
    pub fn create(&self, manifest: &Value, tables: &[TableKind]) -> Result<(), SweepError> {
        for which in tables {
            let folder = self.path.join(which.name());
            fs::create_dir_all(&folder).map_err(|cause| SweepError::write(&folder, cause))?;
        }
        let path = self.manifest_path();
        let write = || -> io::Result<()> {
            let mut file = temporary(&self.path, TEMPORARY)?;
            file.write_all(format!("{manifest:#}\n").as_bytes())?;
            file.as_file().sync_all()?;
            match file.persist_noclobber(&path) {
                Ok(_) => {}
                Err(error) if error.error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error.error),
            }
            sync(&self.path)
        };
        write().map_err(|cause| SweepError::write(&path, cause))
    }

    /// The file of a part.
    pub fn part(&self, which: TableKind, part: u64) -> PathBuf {
        self.path
            .join(which.name())
            .join(format!("part-{part:06}.parquet"))
    }

    /// Whether a part is complete, in all tables.
    pub fn has(&self, tables: &[TableKind], part: u64) -> bool {
        tables.iter().all(|&which| self.part(which, part).is_file())
    }

    /// Creates the temporary file of a part.
    ///
    /// # Errors
    ///
    /// [`SweepError::Write`] if it cannot be created.
    pub fn begin_part(&self, which: TableKind, part: u64) -> Result<PartFile, SweepError> {
        let path = self.part(which, part);
        let folder = self.path.join(which.name());
        match temporary(&folder, TEMPORARY) {
            Ok(file) => Ok(PartFile { file, path, folder }),
            Err(cause) => Err(SweepError::write(&path, cause)),
        }
    }

    /// Deletes temporary files that killed processes have left. It is called when all parts are complete: a
    /// process that still writes a temporary file then computes a part that exists already.
    pub fn tidy(&self, tables: &[TableKind]) {
        for folder in tables
            .iter()
            .map(|which| self.path.join(which.name()))
            .chain([self.path.clone()])
        {
            for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
                let name = entry.file_name();
                let name = name.to_string_lossy();
                if name.starts_with(TEMPORARY[0]) && name.ends_with(TEMPORARY[1]) {
                    // a file that cannot be deleted does no harm
                    let _ = fs::remove_file(entry.path());
                }
            }
        }
    }
}

/// A part that is being written. It has a temporary name until all of it is on the disk.
pub struct PartFile {
    /// The temporary file.
    file: NamedTempFile,
    /// The part.
    path: PathBuf,
    /// Its folder.
    folder: PathBuf,
}

impl PartFile {
    /// The final name of the part.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The temporary file.
    pub fn file(&mut self) -> &mut File {
        self.file.as_file_mut()
    }

    /// Waits until all of the file is on the disk, and then gives it its final name.
    ///
    /// # Errors
    ///
    /// [`SweepError::Write`] if it cannot be written or renamed.
    pub fn finish(self) -> Result<(), SweepError> {
        let Self { file, path, folder } = self;
        let write = || -> io::Result<()> {
            file.as_file().sync_all()?;
            match file.persist(&path) {
                Ok(_) => {}
                // another process has finished this part, the last of the sweep, and has deleted the temporary files
                Err(error) if error.error.kind() == io::ErrorKind::NotFound && path.is_file() => {}
                Err(error) => return Err(error.error),
            }
            sync(&folder)
        };
        write().map_err(|cause| SweepError::write(&path, cause))
    }
}

/// Waits until the names in a folder are on the disk, on systems that offer this.
fn sync(folder: &Path) -> io::Result<()> {
    if cfg!(unix) {
        File::open(folder)?.sync_all()?;
    }
    Ok(())
}
