//! What the program leaves out where a scene does not need it: one list for `--no-skip`, `rayloom info` and `rayloom bench skip`, each
//! saving with a switch of its own.

use std::fmt;

/// A saving; [`SAVINGS`] says what each is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
#[expect(missing_docs, reason = "the table says it")]
pub enum Saving {
    Shaders,
    Attributes,
    Textures,
    Trees,
    Frames,
    Lights,
    Blockers,
    Interiors,
    Shafts,
    Bailout,
    Antialias,
}

/// A row of [`SAVINGS`].
#[derive(Clone, Copy, Debug)]
pub struct SavingInfo {
    /// Which.
    pub saving: Saving,
    /// As the command line has it.
    pub name: &'static str,
    /// What is left out.
    pub what: &'static str,
    /// What the picture is without it.
    pub pixels: Pixels,
}

/// What a picture is without a saving, compared with the usual one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pixels {
    /// The same to the last bit.
    Same,
    /// The same but for the last bits: other shaders are compiled, and their compiler rounds as it likes.
    Rounded,
    /// Another by nature: the saving is a threshold of the scene's.
    Different,
}

const fn row(saving: Saving, name: &'static str, pixels: Pixels, what: &'static str) -> SavingInfo {
    SavingInfo { saving, name, what, pixels }
}

/// All savings, in the order of [`Saving`].
pub const SAVINGS: [SavingInfo; 11] = [
    row(Saving::Shaders, "shaders", Pixels::Rounded, "GPU: code in shaders for what the scene does not use"),
    row(Saving::Attributes, "attributes", Pixels::Same, "GPU: texture coordinates that nothing asks for"),
    row(Saving::Textures, "textures", Pixels::Same, "glTF: decoding pictures that no visible material uses"),
    row(Saving::Trees, "trees", Pixels::Same, "trees over meshes before a ray comes to them"),
    row(Saving::Frames, "frames", Pixels::Same, "animations: trees over meshes that the frame before had too"),
    row(Saving::Lights, "lights", Pixels::Same, "shadow rays to lights behind the surface, and to those that it gives nothing back of"),
    row(Saving::Blockers, "blockers", Pixels::Same, "looking for another blocker where the last one still stands in the way"),
    row(Saving::Interiors, "interiors", Pixels::Same, "asking solids far from a ray's start whether it is inside"),
    row(Saving::Shafts, "shafts", Pixels::Same, "walking the tree for each point of an area light"),
    row(Saving::Bailout, "bailout", Pixels::Different, "rays that add less than adc_bailout"),
    row(Saving::Antialias, "antialias", Pixels::Different, "samples of pixels that are smooth already (antialiasing, noise threshold)"),
];

impl Saving {
    /// Its row.
    pub fn info(self) -> &'static SavingInfo {
        &SAVINGS[self as usize]
    }
}

/// A set of savings.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Savings(u16);

impl Default for Savings {
    fn default() -> Self {
        Self::ALL
    }
}

impl Savings {
    /// Every one: what a picture is usually made with.
    pub const ALL: Self = Self((1 << SAVINGS.len()) - 1);

    /// Those alone that change the picture: all the work is done that leaves it as it is.
    pub fn without_exact() -> Self {
        SAVINGS.iter().filter(|s| s.pixels != Pixels::Different).fold(Self::ALL, |set, s| set.without(s.saving))
    }

    /// Whether `s` is one of them.
    #[inline]
    pub fn has(self, s: Saving) -> bool {
        self.0 & (1 << s as u8) != 0
    }

    /// The others.
    pub fn without(self, s: Saving) -> Self {
        Self(self.0 & !(1 << s as u8))
    }

    /// What a list of names leaves on: `all` takes away every saving that keeps the picture.
    ///
    /// # Errors
    /// A name that is not in the list.
    pub fn parse_without(list: &str) -> Result<Self, String> {
        list.split(',').map(str::trim).try_fold(Self::ALL, |set, name| match SAVINGS.iter().find(|s| s.name == name) {
            Some(s) => Ok(set.without(s.saving)),
            None if name == "all" => Ok(Self(set.0 & Self::without_exact().0)),
            None => {
                let names: Vec<&str> = SAVINGS.iter().map(|s| s.name).collect();
                Err(format!("there is no saving '{name}'; there are {} and all", names.join(", ")))
            }
        })
    }
}

impl fmt::Debug for Savings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set().entries(SAVINGS.iter().filter(|s| self.has(s.saving)).map(|s| s.name)).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_stand_at_the_places_of_their_savings() {
        for (k, s) in SAVINGS.iter().enumerate() {
            assert_eq!(s.saving as usize, k, "{}", s.name);
            assert!(!Savings::parse_without(s.name).expect("its own name").has(s.saving));
        }
    }

    #[test]
    fn all_leaves_what_changes_the_picture() {
        let off = Savings::parse_without("all").expect("a name");
        assert!(SAVINGS.iter().all(|s| off.has(s.saving) == (s.pixels == Pixels::Different)));
        let off = Savings::parse_without("all, bailout").expect("names");
        assert!(!off.has(Saving::Bailout) && off.has(Saving::Antialias));
        assert!(Savings::parse_without("lamps").unwrap_err().contains("there is no saving 'lamps'"));
    }
}
