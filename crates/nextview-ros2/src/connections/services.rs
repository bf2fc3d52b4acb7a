use super::connector::{Connector, failed, reliable};
use crate::messages::{TriggerRequest, TriggerResponse};
use futures_util::StreamExt;
use futures_util::stream::{LocalBoxStream, SelectAll, select_all};
use ros2_client::dds::{Server, ServiceMapping};
use ros2_client::{RmwRequestId, ServiceTypeName};

/// The services of the node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Service {
    /// Takes the next image.
    CaptureRequest,
    /// Returns the next view.
    Plan,
    /// Never proposes the next view again.
    Skip,
    /// Writes the results.
    Save,
    /// Starts a new scan.
    Reset,
}

impl Service {
    const ALL: [Self; 5] = [Self::CaptureRequest, Self::Plan, Self::Skip, Self::Save, Self::Reset];

    fn name(self) -> &'static str {
        match self {
            Self::CaptureRequest => "~/capture",
            Self::Plan => "~/plan",
            Self::Skip => "~/skip",
            Self::Save => "~/save",
            Self::Reset => "~/reset",
        }
    }
}

type Trigger = Server<TriggerRequest, TriggerResponse>;

/// The services that the node offers, all of `std_srvs/srv/Trigger`.
pub struct Services(Vec<(Service, Trigger)>);

impl Services {
    pub fn connect(connector: &mut Connector<'_>) -> Result<Self, String> {
        let server = |service: Service| {
            let name = connector.name(service.name())?;
            let kind = ServiceTypeName::new("std_srvs", "Trigger");
            let server = connector.node.create_server(mapping(), &name, &kind, reliable(10), reliable(10));
            Ok((service, server.map_err(|error| failed(service.name(), &error))?))
        };
        Service::ALL.into_iter().map(server).collect::<Result<_, String>>().map(Self)
    }

    /// All requests in order of arrival; unreadable ones are left out.
    pub fn requests(&self) -> SelectAll<LocalBoxStream<'_, (Service, RmwRequestId)>> {
        select_all(self.0.iter().map(|(service, server)| {
            let requests = server.receive_request_stream();
            requests.filter_map(async |request| Some((*service, request.ok()?.0))).boxed_local()
        }))
    }

    /// Answers a request; does nothing if the client has gone.
    pub fn answer(&self, service: Service, id: RmwRequestId, response: TriggerResponse) {
        if let Some((_, server)) = self.0.iter().find(|(of, _)| *of == service) {
            let _ = server.send_response(id, response);
        }
    }
}

/// How requests are matched to answers, which differs between DDS implementations: that of the implementation
/// used by other ROS programs, selected by the same environment variable.
fn mapping() -> ServiceMapping {
    match std::env::var("RMW_IMPLEMENTATION") {
        Ok(name) if name.contains("cyclonedds") => ServiceMapping::Cyclone,
        _ => ServiceMapping::Enhanced,
    }
}
