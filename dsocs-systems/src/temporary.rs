//! Files that are written under another name until they are complete.

use std::io;
use std::path::Path;

use tempfile::NamedTempFile;

/// A temporary file in a folder, with the permissions that a new file has. Its name begins and ends as given.
pub(crate) fn temporary(folder: &Path, [begin, end]: [&str; 2]) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(begin).suffix(end);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666)); // the umask takes its part off
    }
    builder.tempfile_in(folder)
}
