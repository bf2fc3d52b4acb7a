use super::truth_bytes::n_bytes;
use super::{SimulatedObject, Truth};
use crate::files::{self, Overwrite};
use crate::{BuildIdentity, Fault, ScanConfig};
use nextview::Cancel;
use sha2::{Digest, Sha256};
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Instant, SystemTime};

/// The header of an entry.
const MAGIC: &[u8] = b"nextview truth 1\n";

/// Bytes of a hash.
const HASH: usize = 32;

/// A folder with the ground truths of objects, shared by all processes that use the same objects.
///
/// An entry is named by the hash of everything its truth depends on: the object in metres, the candidates,
/// the part of the configuration that determines them and the camera, and the build of the program. It
/// appears as a whole, has a checksum, and is computed again if the checksum is wrong. Results are therefore
/// the same with and without the cache, whatever the folder contains. If an entry cannot be written or read,
/// its truth is computed.
///
/// When the entries exceed the bound, the least recently used ones are removed. Other files are left alone.
#[derive(Clone, Debug)]
pub struct TruthCache {
    dir: PathBuf,
    max_bytes: u64,
}

impl TruthCache {
    /// Default bound in MB: the truths of about a thousand objects with 5000 candidates each.
    pub const DEFAULT_MB: u64 = 4096;

    /// Opens the cache in a folder, which is created if missing, with a bound in megabytes.
    pub fn open(dir: &Path, max_mb: u64) -> Result<Self, Fault> {
        fs::create_dir_all(dir).map_err(|error| Fault::from(error).while_writing(dir))?;
        Ok(Self { dir: dir.to_owned(), max_bytes: max_mb.saturating_mul(1_000_000) })
    }

    /// Returns the truth of an object made with this configuration: from the folder, otherwise computed and
    /// kept there. Fails like [`Truth::new`].
    pub fn truth(
        &self,
        object: &SimulatedObject,
        config: &ScanConfig,
        cancel: &Cancel,
    ) -> Result<Truth, Fault> {
        let start = Instant::now();
        let key = key(object, config)?;
        let path = self.dir.join(format!("{}.truth", hex(&key)));
        if let Some(bytes) = read(&path, &key, n_bytes(object))
            && let Some(truth) = Truth::of_bytes(object, &bytes[MAGIC.len() + HASH..], start.elapsed())
        {
            return Ok(truth);
        }
        let truth = Truth::new(object, cancel, || ())?;
        // The truth is useful even if it cannot be kept.
        let _ = self.keep(&path, &key, &truth.to_bytes(object));
        Ok(truth)
    }

    fn keep(&self, path: &Path, key: &[u8], truth: &[u8]) -> Result<(), Fault> {
        let mut entry = [MAGIC, key, truth].concat();
        entry.extend(Sha256::digest(&entry));
        if entry.len() as u64 > self.max_bytes {
            return Ok(());
        }
        files::write(path, &Overwrite::results(), |w| Ok(w.write_all(&entry)?))?;
        self.remove_oldest()
    }

    /// Removes entries, including those of killed writers, until the rest is within the bound.
    fn remove_oldest(&self) -> Result<(), Fault> {
        let entry = |path: PathBuf| {
            let name = path.file_name()?.to_str()?;
            let is_ours = name.ends_with(".truth") || name.contains(".truth.") && name.ends_with(".partial");
            let metadata = is_ours.then(|| fs::metadata(&path).ok())??;
            metadata.is_file().then_some((metadata.modified().ok()?, path, metadata.len()))
        };
        let mut entries: Vec<(SystemTime, PathBuf, u64)> =
            fs::read_dir(&self.dir)?.filter_map(|file| entry(file.ok()?.path())).collect();
        entries.sort();
        let mut n_bytes: u64 = entries.iter().map(|entry| entry.2).sum();
        for (_, path, len) in entries {
            if n_bytes <= self.max_bytes {
                break;
            }
            // Another process may have removed it.
            let _ = fs::remove_file(path);
            n_bytes -= len;
        }
        Ok(())
    }
}

/// Reads an entry, without its checksum, and marks it as used; `None` if it is damaged or has another key.
fn read(path: &Path, key: &[u8], n_bytes: usize) -> Option<Vec<u8>> {
    let n_bytes = MAGIC.len() + HASH + n_bytes + HASH;
    let mut entry = files::read(path, n_bytes as u64).ok()?;
    if entry.len() != n_bytes || !entry.starts_with(MAGIC) || !entry[MAGIC.len()..].starts_with(key) {
        return None;
    }
    let sum = entry.split_off(n_bytes - HASH);
    if Sha256::digest(&entry)[..] != sum[..] {
        return None;
    }
    // If the time cannot be set, the entry is removed earlier.
    let _ = File::open(path).and_then(|file| file.set_modified(SystemTime::now()));
    Some(entry)
}

/// The hash of everything that the truth depends on.
fn key(object: &SimulatedObject, config: &ScanConfig) -> Result<[u8; HASH], Fault> {
    let mut hash = Sha256::new_with_prefix(MAGIC);
    hash.update(BuildIdentity::this().to_string());
    // The object itself is hashed, wherever its file is.
    let config = ScanConfig { object: String::new(), ..config.of_object() };
    hash.update(serde_json::to_vec(&config).map_err(Fault::data)?);
    let mesh = object.scene.camera().mesh();
    let counts = [mesh.vertices().len(), mesh.triangles().len(), object.views.len()];
    counts.iter().for_each(|n| hash.update((*n as u64).to_le_bytes()));
    hash.update(object.voxel_size.to_le_bytes());
    for vertex in mesh.vertices() {
        vertex.to_array().iter().for_each(|x| hash.update(x.to_le_bytes()));
    }
    for triangle in mesh.triangles() {
        triangle.iter().for_each(|i| hash.update(i.to_le_bytes()));
    }
    for pose in object.views.poses() {
        let numbers = pose.rotation().to_array().into_iter().chain(pose.translation().to_array());
        numbers.for_each(|x| hash.update(x.to_le_bytes()));
    }
    Ok(hash.finalize().into())
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nextview::sensor::Sensor;
    use std::time::Duration;

    fn config() -> ScanConfig {
        ScanConfig {
            object: "builtin:mug".to_owned(),
            candidates: 12,
            view_seed: Some(0),
            voxel_size_m: Some(0.01),
            ..ScanConfig::default()
        }
    }

    fn object() -> SimulatedObject {
        SimulatedObject::new(&config()).unwrap()
    }

    /// An empty folder, removed at the end.
    struct Folder(PathBuf);

    impl Folder {
        fn new(name: &str) -> Self {
            Self(std::env::temp_dir().join(format!("nextview-truth-{name}-{}", std::process::id())))
        }

        fn cache(&self) -> TruthCache {
            TruthCache::open(&self.0, TruthCache::DEFAULT_MB).unwrap()
        }

        fn entries(&self) -> Vec<PathBuf> {
            let mut entries: Vec<PathBuf> =
                fs::read_dir(&self.0).unwrap().map(|entry| entry.unwrap().path()).collect();
            entries.sort();
            entries
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            // Others clean the temporary folder, too.
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    fn of(cache: &TruthCache, object: &SimulatedObject) -> Vec<u8> {
        cache.truth(object, &config(), &Cancel::default()).unwrap().to_bytes(object)
    }

    #[test]
    fn what_is_read_is_what_was_computed() {
        let (folder, object) = (Folder::new("same"), object());
        let computed = Truth::new(&object, &Cancel::default(), || ()).unwrap();
        let cache = folder.cache();
        cache.truth(&object, &config(), &Cancel::default()).unwrap();
        // Nothing is computed again.
        let cancelled = Cancel::default();
        cancelled.cancel();
        let read = cache.truth(&object, &config(), &cancelled).unwrap();
        for view in 0..object.views.len() {
            assert_eq!(read.visibility.seen(view), computed.visibility.seen(view));
        }
        assert_eq!(read.reachable_voxels, computed.reachable_voxels);
        for sample in 0..object.true_surface.samples().len() {
            let [read, computed] = [&read, &computed].map(|truth| truth.reachable_surface.contains(sample));
            assert_eq!(read, computed);
        }
        let other = ScanConfig { object: "builtin:bracket".to_owned(), ..config() };
        let other = SimulatedObject::new(&other).unwrap();
        assert!(cache.truth(&other, &config(), &cancelled).is_err(), "another object has another truth");
    }

    #[test]
    fn what_is_damaged_or_of_something_else_is_computed_again() {
        let (folder, object) = (Folder::new("damaged"), object());
        let (cache, expected) = (folder.cache(), of(&folder.cache(), &object));
        let path = folder.entries().remove(0);
        let entry = fs::read(&path).unwrap();
        let repaired = |damaged: &[u8]| {
            fs::write(&path, damaged).unwrap();
            assert!(of(&cache, &object) == expected);
            assert!(fs::read(&path).unwrap() == entry && folder.entries().len() == 1);
        };
        for i in [0, MAGIC.len(), MAGIC.len() + HASH + 5, entry.len() / 2, entry.len() - 1] {
            let mut damaged = entry.clone();
            damaged[i] ^= 0x10;
            repaired(&damaged);
        }
        for n in [0, 1, MAGIC.len() + HASH, entry.len() - 1] {
            repaired(&entry[..n]);
        }
        repaired(&[&entry[..], b"x"].concat());
        // Whole, with a valid checksum, but of another key.
        let mut foreign = entry[..entry.len() - HASH].to_vec();
        foreign[MAGIC.len()] ^= 1;
        foreign.extend(Sha256::digest(&foreign));
        repaired(&foreign);
    }

    #[test]
    fn the_key_is_of_all_that_decides_the_truth_and_nothing_else() {
        let key = |change: fn(&mut ScanConfig)| {
            let mut config = config();
            change(&mut config);
            key(&SimulatedObject::new(&config).unwrap(), &config).unwrap()
        };
        let same = key(|_| ());
        assert!(same == key(|config| (config.seed, config.views, config.first_view) = (7, Some(3), 2)));
        for other in [
            key(|config| config.object = "builtin:bracket".to_owned()),
            key(|config| config.size_m = Some(0.1)),
            key(|config| config.candidates = 13),
            key(|config| config.view_seed = Some(3)),
            key(|config| config.voxel_size_m = Some(0.011)),
            key(|config| config.camera = Sensor::D405.intrinsics()),
            key(|config| config.noise.seed = 1),
            key(|config| config.object_box.table = crate::TableRule::Known),
        ] {
            assert!(same != other);
        }
    }

    #[test]
    fn the_entries_that_were_not_used_for_the_longest_time_make_room() {
        let folder = Folder::new("bound");
        let put = |cache: &TruthCache, name: &str| {
            cache.keep(&folder.0.join(name), &[0; HASH], &[7; 1000]).unwrap();
        };
        let cache = folder.cache();
        ["a.truth", "b.truth", "c.truth", "d.truth"].iter().for_each(|name| put(&cache, name));
        fs::write(folder.0.join("notes.txt"), "mine").unwrap();
        fs::write(folder.0.join(".e.truth.77.partial"), "half").unwrap();
        let ages = [("a", 2), ("b", 4), ("c", 3), ("d", 1)].map(|(name, age)| (format!("{name}.truth"), age));
        for (name, age) in ages.into_iter().chain([(".e.truth.77.partial".to_owned(), 9)]) {
            let file = File::options().append(true).open(folder.0.join(name)).unwrap();
            file.set_modified(SystemTime::now() - Duration::from_secs(60 * age)).unwrap();
        }
        let n_bytes = fs::metadata(folder.0.join("a.truth")).unwrap().len();
        put(&TruthCache { max_bytes: 3 * n_bytes, ..cache.clone() }, "f.truth");
        let names: Vec<_> =
            folder.entries().iter().map(|path| path.file_name().unwrap().to_owned()).collect();
        assert_eq!(names, ["a.truth", "d.truth", "f.truth", "notes.txt"]);
        put(&TruthCache { max_bytes: n_bytes - 1, ..cache }, "g.truth");
        assert_eq!(folder.entries().len(), 4, "what is larger than the bound is not kept");
    }

    #[test]
    fn several_writers_are_fine_and_a_folder_that_cannot_be_written_costs_time_alone() {
        let (folder, object) = (Folder::new("writers"), object());
        let expected = Truth::new(&object, &Cancel::default(), || ()).unwrap().to_bytes(&object);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| assert!(of(&folder.cache(), &object) == expected));
            }
        });
        assert_eq!(folder.entries().len(), 1);
        let cache = folder.cache();
        fs::remove_dir_all(&folder.0).unwrap();
        assert!(of(&cache, &object) == expected);
        fs::write(&folder.0, "no folder").unwrap();
        assert!(of(&cache, &object) == expected);
        assert!(TruthCache::open(&folder.0, 1).is_err());
        fs::remove_file(&folder.0).unwrap();
    }
}
