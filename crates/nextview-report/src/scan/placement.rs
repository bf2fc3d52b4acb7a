//! The request to place the object differently, and a description of its turn.

use super::input::ScanPage;
use super::placement_picture::picture;
use crate::text::fixed;
use glam::DVec3;
use nextview::placement::TurnRefusal;
use nextview_scan::{PlacementRecord, ScanRecord, TurnRecord};

/// An object is turned upside down if its underside then faces up within this angle, radians.
const UPSIDE_DOWN: f64 = 0.5;

/// The hidden surface, and the placement that exposes it; `None` if nothing is requested.
pub(super) fn request(record: &ScanRecord) -> Option<String> {
    let PlacementRecord { down, freed_share, unseen_share } = record.next_placement?;
    let share = |share: f64| fixed(100.0 * share, 0);
    Some(format!(
        "{} % of the surface is hidden in this position. {} to see {} % of it.",
        share(unseen_share),
        lay(record, DVec3::from_array(down)),
        share(freed_share),
    ))
}

/// The action on the object, as a clause.
fn lay(record: &ScanRecord, down: DVec3) -> String {
    let up = record.table().map_or(DVec3::Z, |table| table.normal());
    if down.angle_between(up) < UPSIDE_DOWN {
        return "Turn the object upside down".to_owned();
    }
    let [x, y, z] = down.to_array().map(|x| fixed(x, 2));
    format!("Lay it on the side that now faces ({x}, {y}, {z})")
}

/// The turn of the object since the previous scan; `None` if there was none.
pub(super) fn turn(record: &ScanRecord) -> Option<String> {
    let turn = record.turn?;
    if let Some(refusal) = turn.refusal {
        return Some(format!("unknown: {}; the model is from this scan only", refusal_phrase(refusal)));
    }
    let TurnRecord { overlap, residual_mm, error_mm, .. } = turn;
    let angle = turn.now_from_before()?.rotation().angle_between(glam::DQuat::IDENTITY).to_degrees();
    let known = format!(
        "by {} degrees; {} % of the surface shown was already known, {} mm apart",
        fixed(angle, 1),
        fixed(100.0 * overlap?, 0),
        fixed(residual_mm?, 2)
    );
    let error = error_mm.map_or(String::new(), |mm| format!("; misplaced by {} mm", fixed(mm, 2)));
    Some(known + &error)
}

fn refusal_phrase(refusal: TurnRefusal) -> &'static str {
    match refusal {
        TurnRefusal::LittleOverlap => "too little of the surface shown was seen before",
        TurnRefusal::Contradicted => "the object would occupy space that was seen to be free",
        TurnRefusal::Ambiguous => "several turns fit almost equally well",
        TurnRefusal::NotTurned => "the same side is down as before",
        _ => "for a reason unknown to this version",
    }
}

/// The request with its pictures, as HTML; empty if there is none.
pub(super) fn section(page: &ScanPage<'_>) -> String {
    let (Some(text), Some(next)) = (request(page.record), page.record.next_placement) else {
        return String::new();
    };
    let up = page.model.up.unwrap_or(DVec3::Z);
    let pictures = [("current placement", -up), ("requested placement", DVec3::from_array(next.down))]
        .map(|(caption, down)| picture(page.model, up, down, caption));
    format!(
        "<h2>To see more, turn the object</h2><p>{text} Then continue with another scan.</p>\
         <div class=\"placement\">{}</div>",
        pictures.concat()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(down: [f64; 3]) -> ScanRecord {
        let next = PlacementRecord { down, freed_share: 0.9, unseen_share: 0.123 };
        ScanRecord { next_placement: Some(next), ..ScanRecord::default() }
    }

    #[test]
    fn the_request_says_which_side_is_down() {
        let start = "12 % of the surface is hidden in this position. ";
        let end = " to see 90 % of it.";
        let text = |down| request(&record(down)).unwrap();
        assert_eq!(text([0.0, 0.0, 1.0]), format!("{start}Turn the object upside down{end}"));
        let side = "Lay it on the side that now faces (1.00, 0.00, 0.00)";
        assert_eq!(text([1.0, 0.0, 0.0]), format!("{start}{side}{end}"));
        assert_eq!(request(&ScanRecord::default()), None);
    }

    #[test]
    fn a_turn_is_told_with_its_error() {
        let known = TurnRecord {
            refusal: None,
            position_m: Some([0.0; 3]),
            quaternion_xyzw: Some([1.0, 0.0, 0.0, 0.0]),
            overlap: Some(0.43),
            residual_mm: Some(0.412),
            error_mm: Some(0.2),
        };
        let text = |known| turn(&ScanRecord { turn: Some(known), ..ScanRecord::default() }).unwrap();
        assert_eq!(
            text(known),
            "by 180.0 degrees; 43 % of the surface shown was already known, 0.41 mm apart; misplaced by 0.20 mm"
        );
        let refused = TurnRecord { refusal: Some(TurnRefusal::Ambiguous), position_m: None, ..known };
        assert_eq!(
            text(refused),
            "unknown: several turns fit almost equally well; the model is from this scan only"
        );
    }
}
