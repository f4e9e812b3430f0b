//! The same rays by Embree and POV-Ray: their figures stand beside ours, and are held to no bar.

use super::figures::Report;
use super::meshes::Triangles;
use crate::bench::embree;
use crate::math::random::SplitMix64;
use crate::math::{DVec3, Ray};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Other programs to ask where they can answer.
#[derive(Clone, Debug, Default)]
pub struct Peers {
    /// Python with `embreex`, for Embree on meshes.
    pub embree: Option<PathBuf>,
    /// POV-Ray, for `trace()` on its shapes.
    pub povray: bool,
}

/// Most rays that a peer is asked for: they go through files.
const MOST_EMBREE: u64 = 2_000_000;
const MOST_POVRAY: u64 = 20_000;
/// As figures name it.
const POVRAY: &str = "POV-Ray";

/// What POV-Ray's `trace()` meets.
#[derive(Clone, Copy, Debug)]
pub(super) struct PovHit {
    pub point: DVec3,
    pub normal: DVec3,
}

/// A ray, what its case wants to know again, and what POV-Ray met.
pub(super) type Traced<T> = (Ray, T, Option<PovHit>);

impl Report<'_> {
    /// Rays that meet nothing of a mesh that they start in, by Embree as it is and in its robust mode.
    pub(super) fn embree_leaks(&mut self, what: &str, mesh: &Triangles, n: u64, mut ray: impl FnMut(&mut SplitMix64) -> (DVec3, DVec3)) {
        let Some(python) = self.peers.embree.clone() else { return };
        let (n, mut numbers) = (n.min(MOST_EMBREE), SplitMix64(2));
        let rays: Vec<Ray> = (0..n).map(|_| ray(&mut numbers)).map(|(origin, dir)| Ray::new(origin, dir)).collect();
        let faces: Vec<[DVec3; 3]> = (0..mesh.faces.len()).map(|k| mesh.corners(k)).collect();
        for (name, robust) in [("Embree", false), ("Embree, robust", true)] {
            match embree::depths(&python, &faces, &rays, robust) {
                Ok(depths) => {
                    let lost = depths.iter().filter(|t| t.is_infinite()).count();
                    self.peer(name, what.into(), lost as f64, n);
                }
                Err(e) => self.peer(name, format!("{what}: {e}"), f64::NAN, n),
            }
        }
    }

    /// What POV-Ray meets of `object` on at most `n` rays of stream `seed`; none where it is not asked, or fails, which is told.
    pub(super) fn povray<T>(
        &mut self,
        object: &str,
        n: u64,
        seed: u64,
        mut ray: impl FnMut(&mut SplitMix64) -> (Ray, T),
    ) -> Option<Vec<Traced<T>>> {
        if !self.peers.povray {
            return None;
        }
        let mut numbers = SplitMix64(seed);
        let rays: Vec<(Ray, T)> = (0..n.min(MOST_POVRAY)).map(|_| ray(&mut numbers)).collect();
        match trace(object, rays.iter().map(|r| &r.0)) {
            Ok(hits) => Some(rays.into_iter().zip(hits).map(|((ray, told), hit)| (ray, told, hit)).collect()),
            Err(e) => {
                self.povray_figure(format!("no answer: {e}"), f64::NAN, n);
                None
            }
        }
    }

    pub(super) fn povray_figure(&mut self, what: impl Into<String>, value: f64, of: u64) {
        self.peer(POVRAY, what.into(), value, of);
    }
}

/// POV-Ray's `trace()` of every ray, through files in a folder of its own.
fn trace<'a>(object: &str, rays: impl Iterator<Item = &'a Ray>) -> Result<Vec<Option<PovHit>>, String> {
    let mut text = String::new();
    let mut n = 0;
    for r in rays {
        for v in [r.origin, r.dir] {
            let _ = writeln!(text, "{:e},{:e},{:e},", v.x, v.y, v.z);
        }
        n += 1;
    }
    let folder = tempfile::tempdir().map_err(|e| format!("cannot make a temporary folder: {e}"))?;
    let put = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).map_err(|e| format!("cannot write to '{}': {e}", folder.path().display()))
    };
    put("rays.txt", &text)?;
    put("scene.pov", &script(object, n))?;
    run_povray(folder.path())?;
    let answers = std::fs::read_to_string(folder.path().join("hits.txt")).map_err(|e| format!("it wrote no hits: {e}"))?;
    let hits: Vec<Option<PovHit>> = answers.lines().filter_map(hit).collect();
    if hits.len() == n { Ok(hits) } else { Err(format!("it answered {} of {n} rays", hits.len())) }
}

/// One line of the answers: six numbers, the normal's all zero for a miss. `None` for a line that is none.
fn hit(line: &str) -> Option<Option<PovHit>> {
    let v: Vec<f64> = line.split_whitespace().map_while(|w| w.parse().ok()).collect();
    let [x, y, z, a, b, c] = v[..] else { return None };
    let normal = DVec3::new(a, b, c);
    Some((normal != DVec3::ZERO).then_some(PovHit { point: DVec3::new(x, y, z), normal }))
}

fn script(object: &str, n: usize) -> String {
    format!(
        "#version 3.7;\n#declare Thing = object {{ {object} }}\n#fopen In \"rays.txt\" read\n#fopen Out \"hits.txt\" write\n\
         #declare K = 0;\n#while (K < {n})\n  #declare K = K + 1;\n  #read (In, Ox, Oy, Oz, Dx, Dy, Dz)\n  #declare N = <0,0,0>;\n\
         #declare P = trace(Thing, <Ox,Oy,Oz>, <Dx,Dy,Dz>, N);\n\
         #write (Out, str(P.x,0,20), \" \", str(P.y,0,20), \" \", str(P.z,0,20), \" \", str(N.x,0,20), \" \", str(N.y,0,20), \" \", str(N.z,0,20), \"\\n\")\n\
         #end\n#fclose Out\ncamera {{ location -z }}\n"
    )
}

fn run_povray(folder: &Path) -> Result<(), String> {
    let mut command = Command::new("povray");
    command.args(["+Iscene.pov", "+W1", "+H1", "-F", "-D", "-V", "-C", "+WT1"]).current_dir(folder).stdin(Stdio::null());
    let ended = command.output().map_err(|e| format!("cannot run 'povray': {e}"))?;
    let said = String::from_utf8_lossy(&ended.stderr);
    let error = said.lines().find(|l| l.contains("rror:")).unwrap_or("it said nothing");
    if ended.status.success() { Ok(()) } else { Err(error.trim().to_owned()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_hits_or_misses() {
        let told = hit("1 -2 3.5 0 1 0").flatten().expect("a hit");
        assert_eq!((told.point, told.normal), (DVec3::new(1.0, -2.0, 3.5), DVec3::Y));
        assert!(hit("0 0 0 0 0 0").expect("a line").is_none());
        assert!(hit("1 2 3").is_none() && hit("1 2 3 4 5 nonsense").is_none() && hit("").is_none());
    }
}
