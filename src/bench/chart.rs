//! A bar chart as SVG: groups of bars side by side, one colour a series.

use std::fmt::Write;

const COLORS: [&str; 6] = ["#33658a", "#86bbd8", "#f6ae2d", "#f26419", "#5b8e7d", "#8f5b8e"];

/// Bars of `values[group][series]` (none for what was not measured) under `title`; `unit` names the vertical axis.
pub fn bar_chart(title: &str, unit: &str, groups: &[String], series: &[&str], values: &[Vec<Option<f64>>]) -> String {
    let (bar, gap, left, top, height) = (14.0, 18.0, 70.0, 60.0, 320.0);
    let group_width = bar * series.len() as f64 + gap;
    let width = left + group_width * groups.len() as f64 + 30.0;
    let most = values.iter().flatten().flatten().fold(0.0f64, |a, b| a.max(*b)).max(1e-9);
    let step = tick_step(most);
    let y_of = |v: f64| top + height - height * v / most;
    let mut s = String::new();
    let _ = writeln!(
        s,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{:.0}\" font-family=\"sans-serif\" font-size=\"12\">",
        top + height + 90.0
    );
    let _ = writeln!(
        s,
        "<rect width=\"100%\" height=\"100%\" fill=\"white\"/><text x=\"{left}\" y=\"22\" font-size=\"15\">{}</text>",
        escaped(title)
    );
    let mut x = left;
    for (k, name) in series.iter().enumerate() {
        let _ = writeln!(s, "<rect x=\"{x:.0}\" y=\"34\" width=\"11\" height=\"11\" fill=\"{}\"/>", COLORS[k % COLORS.len()]);
        let _ = writeln!(s, "<text x=\"{:.0}\" y=\"44\">{}</text>", x + 15.0, escaped(name));
        x += 30.0 + 7.5 * name.len() as f64;
    }
    let mut v = 0.0;
    while v <= most * 1.0001 {
        let y = y_of(v);
        let _ = writeln!(s, "<line x1=\"{left}\" x2=\"{:.0}\" y1=\"{y:.1}\" y2=\"{y:.1}\" stroke=\"#ddd\"/>", width - 20.0);
        let _ = writeln!(s, "<text x=\"{:.0}\" y=\"{:.1}\" text-anchor=\"end\">{v}</text>", left - 6.0, y + 4.0);
        v = ((v + step) / step).round() * step;
    }
    let _ = writeln!(
        s,
        "<text transform=\"translate(16 {:.0}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
        top + height / 2.0,
        escaped(unit)
    );
    for (k, name) in groups.iter().enumerate() {
        let x0 = left + gap / 2.0 + group_width * k as f64;
        for (j, v) in values[k].iter().enumerate() {
            let Some(v) = v else { continue };
            let (x, y) = (x0 + bar * j as f64, y_of(*v));
            let _ = writeln!(
                s,
                "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{}\"><title>{v:.1}</title></rect>",
                bar - 2.0,
                top + height - y,
                COLORS[j % COLORS.len()]
            );
        }
        let (x, y) = (x0 + bar * series.len() as f64 / 2.0, top + height + 14.0);
        let _ = writeln!(s, "<text transform=\"translate({x:.0} {y:.0}) rotate(-35)\" text-anchor=\"end\">{}</text>", escaped(name));
    }
    s.push_str("</svg>\n");
    s
}

/// A line of [`log_chart`].
pub struct Line {
    /// For the legend.
    pub name: String,
    /// x, y and half the width of the band around y.
    pub points: Vec<[f64; 3]>,
}

/// Lines over axes that are both logarithmic, with bands of confidence.
pub fn log_chart(title: &str, x_unit: &str, y_unit: &str, lines: &[Line]) -> String {
    let (left, top, width, height) = (80.0, 60.0, 520.0, 340.0);
    let decades = |k: usize| {
        let all = || lines.iter().flat_map(|l| &l.points).map(|p| p[k]).filter(|v| *v > 0.0);
        let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
        if low > high { (0.0, 1.0) } else { (low.log10().floor(), high.log10().ceil().max(low.log10().floor() + 1.0)) }
    };
    let (xs, ys) = (decades(0), decades(1));
    let x_of = |v: f64| left + width * ((v.log10() - xs.0) / (xs.1 - xs.0)).clamp(0.0, 1.0);
    let y_of = |v: f64| top + height * (1.0 - (v.max(1e-300).log10() - ys.0) / (ys.1 - ys.0)).clamp(0.0, 1.0);
    let mut s = String::new();
    let _ = writeln!(
        s,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"640\" height=\"470\" font-family=\"sans-serif\" font-size=\"12\">\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/><text x=\"{left}\" y=\"22\" font-size=\"15\">{}</text>",
        escaped(title)
    );
    for k in xs.0 as i32..=xs.1 as i32 {
        let x = x_of(10f64.powi(k));
        let _ = writeln!(s, "<line x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{top}\" y2=\"{:.0}\" stroke=\"#ddd\"/>", top + height);
        let _ = writeln!(s, "<text x=\"{x:.1}\" y=\"{:.0}\" text-anchor=\"middle\">1e{k}</text>", top + height + 18.0);
    }
    for k in ys.0 as i32..=ys.1 as i32 {
        let y = y_of(10f64.powi(k));
        let _ = writeln!(s, "<line x1=\"{left}\" x2=\"{:.0}\" y1=\"{y:.1}\" y2=\"{y:.1}\" stroke=\"#ddd\"/>", left + width);
        let _ = writeln!(s, "<text x=\"{:.0}\" y=\"{:.1}\" text-anchor=\"end\">1e{k}</text>", left - 8.0, y + 4.0);
    }
    let _ = writeln!(
        s,
        "<text x=\"{:.0}\" y=\"{:.0}\" text-anchor=\"middle\">{}</text>",
        left + width / 2.0,
        top + height + 42.0,
        escaped(x_unit)
    );
    let _ = writeln!(
        s,
        "<text transform=\"translate(18 {:.0}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
        top + height / 2.0,
        escaped(y_unit)
    );
    for (k, line) in lines.iter().enumerate() {
        let color = COLORS[k % COLORS.len()];
        let path = |side: f64| line.points.iter().map(move |[x, y, half]| format!("{:.1},{:.1}", x_of(*x), y_of(y + side * half)));
        let band: Vec<String> = path(1.0).chain(path(-1.0).collect::<Vec<_>>().into_iter().rev()).collect();
        let _ = writeln!(s, "<polygon points=\"{}\" fill=\"{color}\" opacity=\"0.2\"/>", band.join(" "));
        let _ = writeln!(
            s,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2\"/>",
            path(0.0).collect::<Vec<_>>().join(" ")
        );
        let y = 40.0 + 15.0 * k as f64;
        let _ =
            writeln!(s, "<text x=\"{:.0}\" y=\"{y:.0}\" fill=\"{color}\" text-anchor=\"end\">{}</text>", left + width, escaped(&line.name));
    }
    s.push_str("</svg>\n");
    s
}

/// 1, 2 or 5 times a power of ten, four to ten of which reach `most`.
fn tick_step(most: f64) -> f64 {
    let rough = most / 6.0;
    let power = 10f64.powf(rough.log10().floor());
    [1.0, 2.0, 5.0].into_iter().map(|m| m * power).find(|s| *s >= rough).unwrap_or(10.0 * power)
}

fn escaped(s: &str) -> String {
    s.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_is_as_high_as_its_value_and_names_are_escaped() {
        let groups = ["a<b".to_owned(), "c".to_owned()];
        let svg = bar_chart("t", "Mrays/s", &groups, &["one", "two"], &[vec![Some(50.0), None], vec![Some(100.0), Some(25.0)]]);
        assert!(svg.contains("a&lt;b") && !svg.contains("a<b"));
        let heights: Vec<&str> =
            svg.lines().filter(|l| l.contains("<title>")).map(|l| l.split("height=\"").nth(1).expect("a height")).collect();
        assert_eq!(heights.iter().map(|h| h.split('"').next().expect("a number")).collect::<Vec<_>>(), ["160.0", "320.0", "80.0"]);
    }
}
