//! Transforms. Source: spec/objects.md, section 14; spec/language.md, section 7.

use super::{PResult, Parser};
use crate::lang::keyword::Kw;
use crate::lang::token::Punct;
use crate::lang::value::Value;
use crate::math::{DVec3, EPSILON, Transform};

impl Parser<'_> {
    /// A transform, if one is next.
    pub(super) fn parse_transform(&mut self) -> PResult<Option<Transform>> {
        let Some(k) = self.peek_kw()? else { return Ok(None) };
        Ok(Some(match k {
            Kw::Translate => {
                self.next()?;
                Transform::translation(self.parse_vector3()?)
            }
            Kw::Rotate => {
                self.next()?;
                Transform::rotation_deg(self.parse_vector3()?)
            }
            Kw::Scale => {
                self.next()?;
                let v = self.parse_scale()?;
                Transform::scaling(v)
            }
            Kw::Matrix => {
                self.next()?;
                self.parse_matrix()?
            }
            Kw::Transform => {
                self.next()?;
                if self.at_punct(Punct::LBrace)? {
                    self.parse_transform_block()?
                } else if let Some(Value::Transform(t)) = self.peek_value()? {
                    let t = **t;
                    self.next()?;
                    t
                } else {
                    return self.expected("transform identifier");
                }
            }
            _ => return Ok(None),
        }))
    }

    fn parse_scale(&mut self) -> PResult<DVec3> {
        let mut v = self.parse_vector3()?;
        if v.to_array().contains(&0.0) {
            self.warn("Illegal Value: Scale by 0.0. Changed to 1.0.");
            v = v.map(|x| if x == 0.0 { 1.0 } else { x });
        }
        if !v.is_finite() {
            return Err(self.error("Scale by a number that is not finite."));
        }
        Ok(v)
    }

    fn parse_matrix(&mut self) -> PResult<Transform> {
        self.expect(Punct::Lt)?;
        let mut m = [0.0; 12];
        for (i, x) in m.iter_mut().enumerate() {
            if i > 0 {
                self.comma()?;
            }
            *x = self.parse_float()?;
        }
        self.expect(Punct::Gt)?;
        for c in 0..3 {
            if (0..3).all(|r| m[3 * r + c].abs() < EPSILON) {
                self.warn(format!("Illegal matrix column: Scale by 0.0. Changed to 1.0 (column {c})."));
                m[3 * c + c] = 1.0;
            }
        }
        Transform::from_rows(m).ok_or_else(|| self.error("Singular matrix in MInvers."))
    }

    /// `{ items }` after `transform`; `inverse` anywhere inverts the whole.
    pub(super) fn parse_transform_block(&mut self) -> PResult<Transform> {
        self.block("transform", |p| {
            let mut all = Transform::IDENTITY;
            let mut inverse = false;
            loop {
                if p.accept_kw(Kw::Inverse)? {
                    inverse = true;
                } else if let Some(Value::Transform(t)) = p.peek_value()? {
                    let t = **t;
                    p.next()?;
                    all = all.then(&t);
                } else if let Some(t) = p.parse_transform()? {
                    all = all.then(&t);
                } else {
                    break;
                }
            }
            Ok(if inverse { all.inverted() } else { all })
        })
    }
}
