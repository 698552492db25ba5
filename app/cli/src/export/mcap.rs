//! A motion as an MCAP file.

use super::markers::markers;
use super::messages::{JointState, Message, Pose, Text, TransformStamped, Transforms};
use super::schemas::schema;
use aghf::dynamics::{forward_kinematics, frame_placement};
use aghf::error::Result;
use aghf::model::{Frame, Model};
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

/// True for the root of a robot that is mounted somewhere in the world.
fn is_mounted(root: &Frame<f64>) -> bool {
    root.body.is_none() && root.carrier.is_none() && root.placement != Placement::identity()
}

/// The links of a robot.
struct Links<'m> {
    model: &'m Model,
    /// The name of the frame in which positions are: the root, or the world in which a robot is mounted.
    base: String,
}

/// The name of the world.
const WORLD: &str = "world";

impl<'m> Links<'m> {
    fn new(model: &'m Model) -> Self {
        let root = model.frames().iter().find(|f| f.body.is_none() && f.carrier.is_none());
        let base = root.map_or("base", |root| if is_mounted(root) { WORLD } else { &root.name });
        Self { model, base: base.to_owned() }
    }

    /// A header in the frame in which positions are.
    fn header(&self, stamp: Stamp) -> Header {
        Header { stamp, frame_id: self.base.clone() }
    }

    /// The transforms from each link to its parent at a configuration, and from the root of a mounted robot to the
    /// world.
    fn transforms(&self, q: &[f64], stamp: Stamp) -> Result<Transforms> {
        let mut placements = vec![Placement::identity(); self.model.dof()];
        forward_kinematics(self.model, q, &mut placements)?;
        let frames = self.model.frames();
        let mut transforms = Vec::new();
        for frame in frames {
            if frame.carrier.is_none() && !is_mounted(frame) {
                continue;
            }
            let own = frame_placement(frame, &placements)?;
            let parent = frame.carrier.as_ref().and_then(|carrier| carrier.parent);
            let parent = parent.map(|parent| &frames[parent]);
            let transform = match parent {
                Some(parent) => relative(&frame_placement(parent, &placements)?, &own),
                None => own,
            };
            transforms.push(TransformStamped {
                header: Header { stamp, frame_id: parent.map_or(&self.base, |parent| &parent.name).clone() },
                child_frame_id: frame.name.clone(),
                transform: Pose::new(&transform),
            });
        }
        Ok(Transforms { transforms })
    }
}
