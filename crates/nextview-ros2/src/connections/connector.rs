//! Joins the network, and defines the quality of service of the node's topics.

use crate::names::Names;
use ros2_client::dds::{Publisher, Subscription, rustdds::Topic};
use ros2_client::qos::{Durability, History, WhenFull};
use ros2_client::{Context, ContextOptions, MessageTypeName, Name, Node, NodeName, NodeOptions, QosProfile};

/// Joins the network of the environment variable ROS_DOMAIN_ID, 0 by default.
pub fn join(names: &Names) -> Result<Node, String> {
    let domain = match std::env::var("ROS_DOMAIN_ID") {
        Err(_) => 0,
        Ok(text) => text
            .trim()
            .parse()
            .ok()
            .filter(|domain| *domain <= 232)
            .ok_or_else(|| format!("ROS_DOMAIN_ID is '{text}', expected a whole number from 0 to 232"))?,
    };
    let context = Context::with_options(ContextOptions::new().domain_id(domain))
        .map_err(|error| format!("cannot join the ROS domain {domain}: {error:?}"))?;
    let name = NodeName::new(&names.namespace, &names.node);
    let name = name.map_err(|error| format!("the node's name {}: {error:?}", names.full()))?;
    // Parameters are fixed at the start, and messages go to stderr and to the topic `status`.
    let options = NodeOptions::new().enable_rosout(false).start_parameter_services(false);
    context
        .new_node(name, options)
        .map_err(|error| format!("cannot make the node {}: {error:?}", names.full()))
}

/// The objects needed to connect.
pub struct Connector<'a> {
    pub node: &'a mut Node,
    pub names: &'a Names,
}

impl Connector<'_> {
    fn topic(&self, name: &str, (package, kind): (&str, &str), qos: &QosProfile) -> Result<Topic, String> {
        let kind = MessageTypeName::new(package, kind);
        self.node.create_topic(&self.name(name)?, kind, qos).map_err(|error| failed(name, &error))
    }

    pub fn subscription<M: 'static>(
        &mut self,
        name: &str,
        kind: (&str, &str),
        qos: QosProfile,
    ) -> Result<Subscription<M>, String> {
        let topic = self.topic(name, kind, &qos)?;
        self.node.create_subscription(&topic, Some(qos)).map_err(|error| failed(name, &error))
    }

    pub fn publisher<M: serde::Serialize>(
        &mut self,
        name: &str,
        kind: (&str, &str),
    ) -> Result<Publisher<M>, String> {
        let qos = latched();
        let topic = self.topic(name, kind, &qos)?;
        self.node.create_publisher(&topic, Some(qos)).map_err(|error| failed(name, &error))
    }

    pub fn name(&self, name: &str) -> Result<Name, String> {
        Name::parse(&self.names.resolve(name)).map_err(|error| failed(name, &error))
    }
}

/// For images: lost ones are not sent again.
pub fn sensor_data() -> QosProfile {
    QosProfile::subscription_default()
}

/// For messages that must all arrive; `depth` of them may wait to be read.
pub fn reliable(depth: usize) -> QosProfile {
    QosProfile::publisher_default().history(History::KeepLast { depth })
}

/// Late subscribers also receive the last message.
fn latched() -> QosProfile {
    let waiting = WhenFull::Fail;
    QosProfile::publisher_default().reliability_reliable(waiting).durability(Durability::TransientLocal)
}

pub fn failed(name: &str, error: &dyn std::fmt::Debug) -> String {
    format!("cannot connect '{name}': {error:?}")
}
