use crate::InspectionRecord;

impl InspectionRecord {
    /// What was found, for people to read: a line for each quantity, then a table of the defects.
    pub fn text(&self) -> String {
        let percent = |share: f64| format!("{:.1} %", 1e2 * share);
        let standard_error = match self.standard_error_median_mm {
            Some(error) => format!(
                "{error:.3} mm (median), {:.3} mm of it common to neighbouring points",
                self.correlated_error_mm
            ),
            None => "not known: most patches hold too few points; try larger ones".to_owned(),
        };
        let mut text = format!(
            "points                 {}\n\
             near the model         {}\n\
             surface inspected      {}\n\
             within {} mm{:width$}{}\n\
             uncertain              {}\n\
             deviation              {:.3} mm (root mean square), {:.3} mm (95 %)\n\
             standard error         {}\n\
             patches                {:.1} mm around each point\n",
            self.n_points,
            percent(self.fitted_share),
            percent(self.inspected_share),
            self.tolerance_mm,
            "",
            percent(self.within_share),
            percent(self.uncertain_share),
            self.deviation_rms_mm,
            self.deviation_p95_mm,
            standard_error,
            self.patch_mm,
            width = 13_usize.saturating_sub(self.tolerance_mm.to_string().len()),
        );
        for surface in &self.surfaces {
            let label = format!("seen within {}°", surface.angle_deg);
            let density = match surface.points_per_mm2 {
                0.0 => String::new(),
                density => format!(", with {density} points/mm² and more"),
            };
            text += &format!("{label:23}{} of {}{density}\n", percent(surface.measured_share), surface.name);
        }
        if self.defects.is_empty() {
            return text + "\nno defect found\n";
        }
        text += "\ndefect  deviation           where (x y z)            size            points\n";
        for (i, defect) in self.defects.iter().enumerate() {
            let mm = |values: [f64; 3]| values.map(|value| format!("{:.1}", 1e3 * value)).join(" ");
            text += &format!(
                "{:6}  {:+.2} ± {:.2} mm     {:>22} mm  {:>14} mm  {:6}\n",
                i + 1,
                defect.deviation_mm,
                defect.standard_error_mm,
                mm(defect.center_m),
                mm(defect.size_m),
                defect.n_points
            );
        }
        text
    }
}
