use crate::InspectionRecord;

impl InspectionRecord {
    /// Formats the results for people: a line per quantity, then a table of the defects.
    pub fn text(&self) -> String {
        let percent = |share: f64| format!("{:.1} %", 1e2 * share);
        let standard_error = match self.standard_error_median_mm {
            Some(error) => format!(
                "{error:.3} mm (median), of which neighbouring points share {:.3} mm",
                self.correlated_error_mm
            ),
            None => "unknown: most patches hold too few points; try larger ones".to_owned(),
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
                density => format!(", with at least {density} points/mm²"),
            };
            text += &format!("{label:23}{} of {}{density}\n", percent(surface.measured_share), surface.name);
        }
        if self.defects.is_empty() {
            return text + "\nno defect found\n";
        }
        let row = |cells: [&str; 5]| {
            let [number, deviation, center, size, points] = cells;
            format!("{number:>6}  {deviation:>18}  {center:>25}  {size:>20}  {points:>6}\n")
        };
        text += "\n";
        text += &row(["defect", "deviation", "where (x y z)", "size (x y z)", "points"]);
        for (i, defect) in self.defects.iter().enumerate() {
            let mm = |values: [f64; 3]| values.map(|value| format!("{:.1}", 1e3 * value)).join(" ") + " mm";
            text += &row([
                &(i + 1).to_string(),
                &format!("{:+.2} ± {:.2} mm", defect.deviation_mm, defect.standard_error_mm),
                &mm(defect.center_m),
                &mm(defect.size_m),
                &defect.n_points.to_string(),
            ]);
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use crate::{DefectRecord, InspectionRecord};

    #[test]
    fn the_head_is_above_its_columns() {
        let defect = DefectRecord {
            center_m: [0.1234, -0.0456, 0.0078],
            size_m: [0.0123, 0.0045, 0.0067],
            deviation_mm: -1.25,
            standard_error_mm: 0.04,
            n_points: 321,
        };
        let record = InspectionRecord { defects: vec![defect], ..InspectionRecord::default() };
        let text = record.text();
        let lines: Vec<&str> = text.lines().collect();
        let [.., head, row] = lines[..] else { panic!("a head and a row in {text}") };
        let end =
            |line: &str, word: &str| line.chars().count() - line.split_once(word).unwrap().1.chars().count();
        for (name, value) in [
            ("defect", "     1"),
            ("deviation", "-1.25 ± 0.04 mm"),
            ("where (x y z)", "123.4 -45.6 7.8 mm"),
            ("size (x y z)", "12.3 4.5 6.7 mm"),
            ("points", "321"),
        ] {
            assert_eq!(end(head, name), end(row, value), "{text}");
        }
    }
}
