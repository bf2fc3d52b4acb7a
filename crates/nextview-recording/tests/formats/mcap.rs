//! Recordings as ROS 2 writes them: a small writer of MCAP files with messages in CDR.

use crate::synthetic::{Folder, SyntheticRecording};
use glam::DVec2;
use nextview::sensor::Intrinsics;
use nextview_recording::{ReadOptions, Recording};

/// Bytes behind the data in these files: statistics, footer and mark.
const BEHIND_DATA: usize = (9 + 46) + (9 + 20) + 8;

/// How a file may be written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Form {
    is_big_endian: bool,
    /// Depth in metres as numbers of 32 bits, not in millimetres.
    is_metres: bool,
    /// Bytes after each row of an image.
    padding: usize,
    /// None: no chunks at all.
    compression: Option<&'static str>,
}

impl Form {
    pub const PLAIN: Self = Self { is_big_endian: false, is_metres: false, padding: 0, compression: None };
    pub const ALL: [Self; 4] = [
        Self::PLAIN,
        Self { is_big_endian: true, padding: 3, compression: Some(""), ..Self::PLAIN },
        Self { is_metres: true, compression: Some("zstd"), ..Self::PLAIN },
        Self { is_metres: true, is_big_endian: true, padding: 8, compression: Some("lz4") },
    ];
}

const DEPTH: &str = "/camera/depth/image_rect_raw";
/// Numbers of topics.
pub const CAMERA: u16 = 0;
pub const POSES: u16 = 2;
pub const TF: u16 = 4;
pub const TF_STATIC: u16 = 5;
pub const COMPRESSED_DEPTH: u16 = 6;
pub const COLOR: u16 = 7;
const TOPICS: [(&str, &str); 8] = [
    ("sensor_msgs/msg/CameraInfo", "/camera/depth/camera_info"),
    ("sensor_msgs/msg/Image", DEPTH),
    ("geometry_msgs/msg/PoseStamped", "/camera_pose"),
    ("sensor_msgs/msg/Image", "/camera/color/image_raw"),
    ("tf2_msgs/msg/TFMessage", "/tf"),
    ("tf2_msgs/msg/TFMessage", "/tf_static"),
    ("sensor_msgs/msg/CompressedImage", "/camera/depth/image_rect_raw/compressedDepth"),
    ("sensor_msgs/msg/CompressedImage", "/camera/depth/color/compressed"),
];

/// Writes values as CDR does.
pub struct Cdr {
    bytes: Vec<u8>,
    is_big_endian: bool,
}

impl Cdr {
    /// A message that begins with a header.
    pub fn new(is_big_endian: bool, time: f64) -> Self {
        let mut cdr = Self { bytes: Vec::new(), is_big_endian };
        cdr.header(time, "camera");
        cdr
    }

    /// One without a header.
    pub fn bare() -> Self {
        Self { bytes: Vec::new(), is_big_endian: false }
    }

    pub fn header(&mut self, time: f64, frame: &str) -> &mut Self {
        self.u32(time.floor() as u32).u32(((time - time.floor()) * 1e9).round() as u32).text(frame)
    }

    fn number<const N: usize>(&mut self, mut little: [u8; N]) -> &mut Self {
        self.bytes.resize(self.bytes.len().next_multiple_of(N), 0);
        if self.is_big_endian {
            little.reverse();
        }
        self.bytes.extend(little);
        self
    }

    pub fn u32(&mut self, value: u32) -> &mut Self {
        self.number(value.to_le_bytes())
    }

    pub fn f64s(&mut self, values: &[f64]) -> &mut Self {
        values.iter().for_each(|value| _ = self.number(value.to_le_bytes()));
        self
    }

    pub fn text(&mut self, text: &str) -> &mut Self {
        self.u32(text.len() as u32 + 1).bytes.extend(text.bytes().chain([0]));
        self
    }

    /// Bytes after their number.
    pub fn blob(&mut self, bytes: &[u8]) -> &mut Self {
        self.u32(bytes.len() as u32).bytes.extend(bytes);
        self
    }

    pub fn message(&self) -> Vec<u8> {
        [&[0, !self.is_big_endian as u8, 0, 0], &self.bytes[..]].concat()
    }
}

/// The recording as a file, with images in colour that do not matter.
pub fn bytes(synthetic: &SyntheticRecording, form: Form) -> Vec<u8> {
    file(form, &messages(synthetic, form))
}

/// Messages with the numbers of their topics.
pub fn messages(synthetic: &SyntheticRecording, form: Form) -> Vec<(u16, Vec<u8>)> {
    let mut messages = vec![(0, camera_info(synthetic, form))];
    for (i, pose) in synthetic.poses.iter().enumerate() {
        let time = 1_700_000_000.0 + 0.1 * i as f64;
        let (t, q) = (pose.translation(), pose.rotation());
        let mut cdr = Cdr::new(form.is_big_endian, time + 0.004);
        messages.push((2, cdr.f64s(&t.to_array()).f64s(&q.to_array()).message()));
        messages.push((1, depth_image(synthetic, i, time, form)));
        messages.push((3, image(form.is_big_endian, time, [2, 1], "rgb8", &[7; 6]).message()));
    }
    messages
}

fn camera_info(synthetic: &SyntheticRecording, form: Form) -> Vec<u8> {
    let camera = synthetic.camera;
    let (f, c) = (camera.focal(), camera.center());
    let mut cdr = Cdr::new(form.is_big_endian, 0.0);
    cdr.u32(camera.height()).u32(camera.width()).text("plumb_bob").u32(5).f64s(&[0.0; 5]);
    cdr.f64s(&[f.x, 0.0, c.x, 0.0, f.y, c.y, 0.0, 0.0, 1.0]).f64s(&[0.0; 9 + 12]).message()
}

fn depth_image(synthetic: &SyntheticRecording, i: usize, time: f64, form: Form) -> Vec<u8> {
    let pixel = |mm: &u16| -> Vec<u8> {
        // As the reader makes metres of millimetres, so that the maps can be the same; 0 is NaN there.
        let metres = if *mm == 0 { f32::NAN } else { (*mm as f64 * 0.001) as f32 };
        match (form.is_metres, form.is_big_endian) {
            (false, false) => mm.to_le_bytes().to_vec(),
            (false, true) => mm.to_be_bytes().to_vec(),
            (true, false) => metres.to_le_bytes().to_vec(),
            (true, true) => metres.to_be_bytes().to_vec(),
        }
    };
    let width = synthetic.camera.width() as usize;
    let rows = synthetic.images[i].chunks(width);
    let rows = rows.map(|row| [row.iter().flat_map(pixel).collect(), vec![9; form.padding]].concat());
    let data = rows.collect::<Vec<_>>().concat();
    let encoding = if form.is_metres { "32FC1" } else { "16UC1" };
    let size = [synthetic.camera.width(), synthetic.camera.height()];
    image(form.is_big_endian, time, size, encoding, &data).message()
}

fn image(is_big_endian: bool, time: f64, [width, height]: [u32; 2], encoding: &str, data: &[u8]) -> Cdr {
    let mut cdr = Cdr::new(is_big_endian, time);
    cdr.u32(height).u32(width).text(encoding).bytes.push(is_big_endian as u8);
    cdr.u32(data.len() as u32 / height).u32(data.len() as u32).bytes.extend(data);
    cdr
}

pub fn file(form: Form, messages: &[(u16, Vec<u8>)]) -> Vec<u8> {
    let mut names = Vec::new();
    for (id, (schema, topic)) in (0_u16..).zip(TOPICS) {
        let schema_id = (id + 1).to_le_bytes();
        names.extend(record(3, &[&schema_id, &*text(schema), &*text("ros2msg"), &[0; 4]].concat()));
        names.extend(record(
            4,
            &[&id.to_le_bytes(), &schema_id, &*text(topic), &*text("cdr"), &[0; 4]].concat(),
        ));
    }
    let message =
        |(channel, data): &(u16, Vec<u8>)| record(5, &[&channel.to_le_bytes()[..], &[0; 20], data].concat());
    let mut file = b"\x89MCAP0\r\n".to_vec();
    file.extend(record(1, &[text("ros2"), text("test")].concat()));
    match form.compression {
        None => file.extend([names, messages.iter().flat_map(message).collect()].concat()),
        Some(compression) => {
            file.extend(chunk(compression, &names));
            for messages in messages.chunks(5) {
                file.extend(chunk(compression, &messages.iter().flat_map(message).collect::<Vec<u8>>()));
            }
        }
    }
    // Recorders leave the sum of the data out where chunks have sums of their own.
    let crc = if form.compression.is_none() { crc32fast::hash(&file) } else { 0 };
    file.extend(record(15, &crc.to_le_bytes()));
    let summary_start = file.len();
    let n_messages = messages.len() as u64;
    let statistics = [&n_messages.to_le_bytes()[..], &[0; 2 + 4 + 4 + 4 + 4 + 8 + 8 + 4]].concat();
    file.extend(record(11, &statistics));
    let head = [&[2][..], &20_u64.to_le_bytes(), &(summary_start as u64).to_le_bytes(), &[0; 8]].concat();
    file.extend(head);
    file.extend(crc32fast::hash(&file[summary_start..]).to_le_bytes());
    file.extend(b"\x89MCAP0\r\n");
    file
}

fn chunk(compression: &str, plain: &[u8]) -> Vec<u8> {
    let packed = match compression {
        "zstd" => ruzstd::encoding::compress_to_vec(plain, ruzstd::encoding::CompressionLevel::Fastest),
        "lz4" => {
            let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
            std::io::Write::write_all(&mut encoder, plain).unwrap();
            encoder.finish().unwrap()
        }
        _ => plain.to_vec(),
    };
    let (size, length) = ((plain.len() as u64).to_le_bytes(), (packed.len() as u64).to_le_bytes());
    let crc = crc32fast::hash(plain).to_le_bytes();
    record(6, &[&[0; 16], &size[..], &crc, &text(compression), &length, &packed].concat())
}

fn record(opcode: u8, content: &[u8]) -> Vec<u8> {
    [&[opcode], &(content.len() as u64).to_le_bytes()[..], content].concat()
}

fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat()
}

pub fn open(folder: &Folder, bytes: &[u8], options: &ReadOptions) -> Result<Recording, String> {
    folder.write("bag.mcap", bytes);
    Recording::open(&folder.0.join("bag.mcap"), options).map_err(|error| error.to_string())
}

/// The error that a recording of three frames gives when its messages are changed.
fn error(folder: &str, change: impl Fn(&mut Vec<(u16, Vec<u8>)>)) -> String {
    let mut messages = messages(&SyntheticRecording::new(3), Form::PLAIN);
    change(&mut messages);
    let folder = Folder::new(&format!("mcap-{folder}"));
    open(&folder, &file(Form::PLAIN, &messages), &ReadOptions::default()).unwrap_err()
}

#[track_caller]
pub fn assert_parts(error: &str, parts: &[&str]) {
    parts.iter().for_each(|part| assert!(error.contains(part), "expected {part:?} in {error:?}"));
}

#[test]
fn files_that_are_cut_or_changed_are_refused() {
    let folder = Folder::new("mcap-cut");
    for form in Form::ALL {
        let whole = bytes(&SyntheticRecording::new(2), form);
        // What follows the data is not needed.
        for length in (0..whole.len() - BEHIND_DATA).step_by(whole.len() / 40) {
            let error = open(&folder, &whole[..length], &ReadOptions::default()).unwrap_err();
            let parts = if length < 8 {
                ["bag.mcap: ", "is not an MCAP file"]
            } else {
                ["bag.mcap: byte ", "mcap recover"]
            };
            assert_parts(&error, &parts);
        }
        // Whatever a bit may do, it is no panic; in a chunk it is always noticed.
        for at in (8..whole.len()).step_by(whole.len() / 60) {
            let mut changed = whole.clone();
            changed[at] ^= 0x10;
            let _ = open(&folder, &changed, &ReadOptions::default());
        }
    }
    let mut damaged = bytes(&SyntheticRecording::new(2), Form::ALL[1]);
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    let error = open(&folder, &damaged, &ReadOptions::default()).unwrap_err();
    assert_parts(&error, &["bag.mcap: record at byte ", "a chunk is damaged"]);
    assert_parts(
        &open(&folder, b"ply\nformat", &ReadOptions::default()).unwrap_err(),
        &["is not an MCAP file"],
    );
}

/// What is read from a file: optics, poses, times and images.
fn content(folder: &Folder, bytes: &[u8]) -> Result<String, String> {
    let Recording { intrinsics, frames, skipped, notes } = open(folder, bytes, &ReadOptions::default())?;
    let mut content = format!("{intrinsics:?} {skipped:?} {notes:?}");
    for frame in &frames {
        let loaded = frame.load().map_err(|error| error.to_string())?;
        content += &format!("{} {:?} {:?}", frame.name, frame.timestamp_s, loaded);
    }
    Ok(content)
}

/// Two frames of a few pixels.
fn tiny() -> SyntheticRecording {
    let camera = Intrinsics::pinhole(8, 6, DVec2::splat(7.5), DVec2::new(3.5, 2.5)).unwrap();
    let poses = SyntheticRecording::new(2).poses;
    SyntheticRecording { camera, poses, images: vec![(300..348).collect(), (310..358).collect()] }
}

#[test]
fn a_changed_byte_is_noticed_or_changes_nothing() {
    let folder = Folder::new("mcap-changed-byte");
    for form in Form::ALL {
        let whole = bytes(&tiny(), form);
        let expected = content(&folder, &whole).unwrap();
        let mut n_refused = 0;
        // Chunks guard each other's bytes alike, so that a share of them will do.
        let step = if form.compression.is_some() { 11 } else { 1 };
        for at in (0..whole.len()).step_by(step) {
            let mut changed = whole.clone();
            changed[at] ^= 1 << (at % 8);
            match content(&folder, &changed) {
                Ok(found) => assert_eq!(found, expected, "byte {at} of {} in {form:?}", whole.len()),
                Err(_) => n_refused += 1,
            }
        }
        // The others are behind the data, or times and names that nobody needs.
        assert!(n_refused * step > whole.len() * 3 / 4, "{n_refused} of {} in {form:?}", whole.len());
    }
}

#[test]
fn check_sums_and_counts_of_the_file_are_compared() {
    let folder = Folder::new("mcap-check-sums");
    let whole = bytes(&tiny(), Form::PLAIN);
    let error = |bytes: &[u8]| open(&folder, bytes, &ReadOptions::default()).unwrap_err();
    // The last byte of the last image but one; images are what no other check sees.
    let mut pixel = whole.clone();
    let at = whole.windows(2).position(|pair| pair == 320_u16.to_le_bytes()).unwrap();
    pixel[at] ^= 1;
    assert_parts(&error(&pixel), &["record at byte ", "the file's data is damaged: its checksum is "]);
    // 0 is no check sum.
    let data_end = whole.len() - BEHIND_DATA - 4;
    pixel[data_end..data_end + 4].fill(0);
    assert!(open(&folder, &pixel, &ReadOptions::default()).is_ok());

    let mut summary = whole.clone();
    summary[whole.len() - BEHIND_DATA + 9] ^= 1;
    assert_parts(&error(&summary), &["record at byte ", "the file's summary is damaged"]);
    let crc = whole.len() - 8 - 4;
    summary[crc..crc + 4].fill(0);
    assert_parts(&error(&summary), &["it holds 7 messages, but its summary counts 6"]);
    // Without its summary, the data is still whole.
    for n in 1..BEHIND_DATA {
        assert!(open(&folder, &whole[..whole.len() - n], &ReadOptions::default()).is_ok(), "{n}");
    }
}

#[test]
fn a_message_that_changed_since_is_refused() {
    for form in [Form::PLAIN, Form::ALL[1]] {
        let folder = Folder::new(&format!("mcap-replaced-{}", form.compression.is_some()));
        let recording = open(&folder, &bytes(&tiny(), form), &ReadOptions::default()).unwrap();
        recording.frames[1].load().unwrap();
        let mut other = tiny();
        other.images[1][5] += 1;
        folder.write("bag.mcap", bytes(&other, form));
        assert_parts(
            &recording.frames[1].load().unwrap_err().to_string(),
            &["bag.mcap: ", "the file has changed since it was opened"],
        );
    }
}

#[test]
fn topics_that_lack_or_are_several_are_named() {
    let without = |name: &str, topic: u16| error(name, |messages| messages.retain(|(of, _)| *of != topic));
    assert_parts(&without("no-depth", 1), &["there is no depth image topic"]);
    assert_parts(&without("no-poses", 2), &["there is no PoseStamped topic"]);
    assert_parts(&without("no-camera", 0), &["there is no CameraInfo topic"]);

    // The colour topic carries depth as well.
    let synthetic = SyntheticRecording::new(3);
    let mut messages = messages(&synthetic, Form::PLAIN);
    let depths: Vec<Vec<u8>> =
        messages.iter().filter(|(of, _)| *of == 1).map(|(_, data)| data.clone()).collect();
    let others = messages.iter_mut().filter(|(of, _)| *of == 3);
    others.zip(&depths).for_each(|((_, data), depth)| data.clone_from(depth));
    let folder = Folder::new("mcap-several");
    let bytes = file(Form::PLAIN, &messages);
    let several = open(&folder, &bytes, &ReadOptions::default()).unwrap_err();
    let names =
        format!("several depth image topics, /camera/color/image_raw, {DEPTH}: choose one as `depth_topic`");
    assert_parts(&several, &[&names]);
    let choose = |topic: &str| ReadOptions { depth_topic: Some(topic.to_owned()), ..ReadOptions::default() };
    assert_eq!(open(&folder, &bytes, &choose(DEPTH)).unwrap().frames.len(), 3);
    assert_parts(&open(&folder, &bytes, &choose("/depth")).unwrap_err(), &["but no /depth as `depth_topic`"]);
}

#[test]
fn messages_that_cannot_be_are_refused() {
    let nth = |messages: &mut Vec<(u16, Vec<u8>)>, topic: u16, n: usize, data: Vec<u8>| {
        messages.iter_mut().filter(|(of, _)| *of == topic).nth(n).unwrap().1 = data;
    };
    let pose = |values: [f64; 7]| Cdr::new(false, 1_700_000_000.104).f64s(&values).message();
    let cut = error("cut-message", |messages| nth(messages, 2, 1, vec![0, 1, 0, 0, 5]));
    assert_parts(
        &cut,
        &["record at byte ", "message 2 of /camera_pose: byte 0: 4 bytes expected, but only 1"],
    );
    let millimetres =
        error("mm", |messages| nth(messages, 2, 1, pose([900.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])));
    assert_parts(&millimetres, &["message 2 of /camera_pose: the position is 900 m", "millimetres?"]);
    let stretched =
        error("not-rigid", |messages| nth(messages, 2, 0, pose([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0])));
    assert_parts(&stretched, &["message 1 of /camera_pose: length of the quaternion is 2"]);
    let small = image(false, 1_700_000_000.1, [40, 60], "16UC1", &[1; 40 * 60 * 2]).message();
    let small = error("small", |messages| nth(messages, 1, 1, small.clone()));
    assert_parts(
        &small,
        &["bag.mcap: message 2 of /camera/depth", "40 x 60 pixels, but the intrinsics are for 80 x 60"],
    );
    let twin = error("twin", |messages| {
        let first = messages.iter().find(|(of, _)| *of == 1).unwrap().1.clone();
        nth(messages, 1, 2, first);
    });
    assert_parts(
        &twin,
        &["message 3 of /camera/depth", "has the same timestamp", "as message 1 of /camera/depth"],
    );
}

#[test]
fn images_far_from_any_pose_are_left_out() {
    let synthetic = SyntheticRecording::new(3);
    let mut messages = messages(&synthetic, Form::PLAIN);
    let second = messages.iter().position(|(of, _)| *of == 2).unwrap() + 3;
    messages.remove(second);
    let folder = Folder::new("mcap-hole");
    let recording = open(&folder, &file(Form::PLAIN, &messages), &ReadOptions::default()).unwrap();
    assert_eq!((recording.frames.len(), recording.skipped.len()), (2, 1));
    let told = recording.skipped[0].to_string();
    assert!(told.starts_with("message 2 of ") && told.contains("ms away in time, more than 20 ms"), "{told}");
}
