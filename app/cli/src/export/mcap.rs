//! A motion as an MCAP file.

use super::markers::markers;
use super::messages::{JointState, Message, Pose, Text, TransformStamped, Transforms};
use super::schemas::schema;
use aghf::dynamics::{forward_kinematics, frame_placement};
use aghf::error::Result;
use aghf::model::Model;
use aghf::spatial::Placement;
use aghf_scenario::{Header, JointTrajectory, Scenario, Stamp};
use cdr_encoding::to_vec;
use mcap::records::MessageHeader;
use mcap::{WriteOptions, Writer};
use std::collections::BTreeMap;
use std::io::{self, Seek, Write};

/// The rate of a recording, Hz, unless another is chosen: smooth on a screen.
pub const DEFAULT_RATE: f64 = 100.0;

/// The header of little-endian CDR.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// The quality of service by which a later subscriber gets the last message too, with all keys that `ros2 bag` asks
/// for: the last message, reliable, transient local, and no deadline.
const LATCHED: &str = "\
- history: 1
  depth: 1
  reliability: 1
  durability: 1
  deadline: {sec: 9223372036, nsec: 854775807}
  lifespan: {sec: 9223372036, nsec: 854775807}
  liveliness: 1
  liveliness_lease_duration: {sec: 9223372036, nsec: 854775807}
  avoid_ros_namespace_conventions: false
";

/// Writes an MCAP file of a motion as ROS 2 records it, not compressed, from time zero. At the beginning it has
/// `/robot_description`, the URDF; `/obstacles`, a marker for each; and `/plan`, the motion; then for each point of
/// that `/joint_states` with the torques as effort, and `/tf` with all links.
///
/// # Errors
/// The writer fails, or the plan has another number of joints than the robot.
pub fn write_mcap(scenario: &Scenario, plan: JointTrajectory, writer: impl Write + Seek) -> io::Result<()> {
    let mut file = Recording::new(writer)?;
    let urdf = Text { data: scenario.source.text.to_string() };
    file.add("/robot_description", LATCHED, 0, &urdf)?;
    let links = Links::new(&scenario.model);
    let obstacles = markers(scenario.scene.obstacles(), &links.header(Stamp::default()));
    file.add("/obstacles", LATCHED, 0, &obstacles)?;
    file.add("/plan", LATCHED, 0, &plan)?;
    for point in plan.points {
        let stamp = point.time_from_start;
        let at = stamp.nanoseconds();
        let transforms = links.transforms(&point.positions, stamp);
        let transforms = transforms.map_err(io::Error::other)?;
        let state = JointState {
            header: links.header(stamp),
            name: plan.joint_names.clone(),
            position: point.positions,
            velocity: point.velocities,
            effort: point.effort,
        };
        file.add("/joint_states", "", at, &state)?;
        file.add("/tf", "", at, &transforms)?;
    }
    file.writer.finish().map(drop).map_err(io::Error::other)
}

/// An MCAP file that is being written.
struct Recording<W: Write + Seek> {
    writer: Writer<W>,
    /// The numbers of messages by the identifiers of their channels.
    counts: BTreeMap<u16, u32>,
}

impl<W: Write + Seek> Recording<W> {
    fn new(writer: W) -> io::Result<Self> {
        let library = format!("aghf {}", env!("CARGO_PKG_VERSION"));
        let options = WriteOptions::new().profile("ros2").library(library);
        Ok(Self { writer: options.create(writer).map_err(io::Error::other)?, counts: BTreeMap::new() })
    }

    /// Adds a message at a time in ns, with the quality of service of its channel, empty for the default one.
    fn add<M: Message>(&mut self, topic: &str, quality: &str, at: u64, message: &M) -> io::Result<()> {
        let [package, name] = M::TYPE;
        let text = schema(M::TYPE);
        let schema = (self.writer)
            .add_schema(&format!("{package}/msg/{name}"), "ros2msg", text.as_bytes())
            .map_err(io::Error::other)?;
        let quality = ("offered_qos_profiles".to_owned(), quality.to_owned());
        let metadata = BTreeMap::from([quality]);
        let channel_id = (self.writer).add_channel(schema, topic, "cdr", &metadata).map_err(io::Error::other)?;
        let count = self.counts.entry(channel_id).or_default();
        let header = MessageHeader { channel_id, sequence: *count, log_time: at, publish_time: at };
        *count += 1;
        let mut data = ENCAPSULATION.to_vec();
        data.extend(to_vec::<M, byteorder::LittleEndian>(message).map_err(io::Error::other)?);
        (self.writer).write_to_known_channel(&header, &data).map_err(io::Error::other)
    }
}

/// A placement as seen from another one.
fn relative(from: &Placement<f64>, to: &Placement<f64>) -> Placement<f64> {
    let back = from.rotation.transpose();
    Placement::new(back * to.rotation, back * (to.translation - from.translation))
}

/// The links of a robot.
struct Links<'m> {
    model: &'m Model,
    /// The name of the root.
    root: String,
}

impl<'m> Links<'m> {
    fn new(model: &'m Model) -> Self {
        let base = model.frames().iter().find(|f| f.body.is_none() && f.carrier.is_none());
        Self { model, root: base.map_or("base", |frame| &frame.name).to_owned() }
    }

    /// A header in the frame of the root.
    fn header(&self, stamp: Stamp) -> Header {
        Header { stamp, frame_id: self.root.clone() }
    }

    /// The transforms from each link to its parent at a configuration.
    fn transforms(&self, q: &[f64], stamp: Stamp) -> Result<Transforms> {
        let mut placements = vec![Placement::identity(); self.model.dof()];
        forward_kinematics(self.model, q, &mut placements)?;
        let frames = self.model.frames();
        let mut transforms = Vec::new();
        for frame in frames {
            let Some(carrier) = &frame.carrier else {
                continue;
            };
            let own = frame_placement(frame, &placements)?;
            let parent = carrier.parent.map(|parent| &frames[parent]);
            let transform = match parent {
                Some(parent) => relative(&frame_placement(parent, &placements)?, &own),
                None => own,
            };
            transforms.push(TransformStamped {
                header: Header { stamp, frame_id: parent.map_or(&self.root, |parent| &parent.name).clone() },
                child_frame_id: frame.name.clone(),
                transform: Pose::new(&transform),
            });
        }
        Ok(Transforms { transforms })
    }
}
