use nextview::session::StopReason;

/// Returns the reason why a scan stopped, as a clause that follows "because".
pub fn stop_phrase(reason: StopReason) -> &'static str {
    match reason {
        StopReason::ViewLimit => "the view limit was reached",
        StopReason::Converged => "the map's entropy fell below its threshold (converged)",
        StopReason::Complete => "the surface is estimated to be as complete as requested",
        StopReason::NoProgress => "the last six views showed almost nothing new",
        StopReason::LittleToGain => "the next views are expected to add almost nothing",
        StopReason::TimeLimit => "the time limit was reached",
        StopReason::PathLimit => "the path would exceed its limit",
        StopReason::Cancelled => "the scan was cancelled",
        StopReason::NothingToGain => "no candidate gains anything",
        StopReason::NoObject => "the camera saw no object",
        StopReason::BoxTooLarge => "the object's box would need more memory than allowed",
        StopReason::OutOfReach => "the robot can reach no other candidate",
        StopReason::Ended => "it was ended by the user",
        _ => "another stop rule applied",
    }
}
