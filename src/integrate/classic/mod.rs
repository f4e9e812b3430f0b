//! POV-Ray's light transport, ray by ray, as spec/light.md describes it. Deterministic: the same rays in the same order see the same.
//!
//! [`Tracer`] holds what one stream of rays changes (level, random streams, memories); [`ScenePlan`] what all share.
//! A pixel asks [`Tracer::pixel`]; the way down is `trace` → `shade` → `lights` → `shadow`, with `refract`, `sky` and `media` beside.

mod area_packet;
mod emitters;
mod inline_vec;
mod lights;
mod media;
mod photons;
mod pixel;
mod plan;
mod pretrace;
mod principled;
mod radiosity;
mod radiosity_cache;
mod ray;
mod refract;
mod shade;
mod shadow;
mod shafts;
mod sky;
mod subsurface;
mod texturing;
mod trace;

pub use emitters::{EmitterPoint, Piece};
pub use photons::{PhotonError, PhotonMaps, PhotonStats};
pub use pixel::{bent, single_ray};
pub use plan::{ScenePlan, interiors_at};
pub use pretrace::{pretrace_in_order, pretrace_side_by_side};
pub use principled::SHARP_MIRROR;
pub use ray::InteriorList;
pub use shafts::takes_shafts;
pub use trace::Tracer;
