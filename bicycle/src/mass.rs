//! Bodies to lumps: bicycle, rider and load; the literature's 25 parameters.
//!
//! Lumps are taken about the rear contact point, h up:
//! `I_xx = Σ(I_i + m h_i²)`, `I_zz = Σ(I_i + m x_i²)`, `I_xz = Σ(I_xz,i + m x_i h_i)`.

use crate::parameters::Parameters;
use crate::real::Real;
use crate::whipple::FourBodies;

/// A rigid body: mass [kg], centre of mass [m] forward of the rear contact and above the ground,
/// inertias [kg m²] about its own centre of mass, x forward, z up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body<T = f64> {
    /// Mass [kg].
    pub mass: T,
    /// Centre of mass, forward of the rear contact [m].
    pub x: T,
    /// Centre of mass above the ground [m].
    pub h: T,
    /// Own roll inertia [kg m²].
    pub roll_inertia: T,
    /// Own yaw inertia [kg m²].
    pub yaw_inertia: T,
    /// Own product of inertia, sign as in `Σ(I_xz + m x h)` [kg m²].
    pub cross_inertia: T,
}

impl Body {
    /// Whether matter can have this mass and these inertias in the plane of symmetry: positive
    /// mass, positive definite inertia.
    pub fn is_possible(&self) -> bool {
        let Self {
            mass,
            roll_inertia,
            yaw_inertia,
            cross_inertia,
            ..
        } = *self;
        mass > 0.0
            && roll_inertia > 0.0
            && roll_inertia * yaw_inertia > cross_inertia * cross_inertia
    }
}

/// A set of bodies seen as one: the first six rows of the parameter table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lumps<T = f64> {
    /// M [kg].
    pub total_mass: T,
    /// `L_1` [m].
    pub cog_to_rear: T,
    /// h [m].
    pub cog_height: T,
    /// `I_xx` about the rear contact [kg m²].
    pub roll_inertia: T,
    /// `I_zz` about the rear contact [kg m²].
    pub yaw_inertia: T,
    /// `I_xz` about the rear contact [kg m²].
    pub cross_inertia: T,
}

/// The paper's bicycle: 17.5 kg, .507 m (Table 4); height and inertias assumed from measured
/// bicycles of that mass (Moore 2012).
pub const PAPER_BICYCLE: Body = Body {
    mass: 17.5,
    x: 0.507,
    h: 0.50,
    roll_inertia: 1.20,
    yaw_inertia: 3.2,
    cross_inertia: 0.15,
};

/// A seated rider of `mass` [kg] and `height` [m]. The seat (.30 m before the rear contact,
/// .62 m up) and the inertias at 75 kg and 1.78 m are assumed from measured riders (Moore 2012)
/// and scaled with mass · height².
pub const fn rider(mass: f64, height: f64) -> Body {
    let scale = (mass / 75.0) * (height / 1.78) * (height / 1.78);
    Body {
        mass,
        x: 0.30,
        h: 0.62 + 0.47 * height / 1.83,
        roll_inertia: 7.9 * scale,
        yaw_inertia: 2.3 * scale,
        cross_inertia: -1.5 * scale,
    }
}

/// The lumps of `bodies`.
pub const fn compose(bodies: &[Body]) -> Lumps {
    let (mut m, mut mx, mut mh, mut xx, mut zz, mut xz) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    let mut i = 0;
    while i < bodies.len() {
        let b = bodies[i];
        m += b.mass;
        mx += b.mass * b.x;
        mh += b.mass * b.h;
        xx += b.roll_inertia + b.mass * b.h * b.h;
        zz += b.yaw_inertia + b.mass * b.x * b.x;
        xz += b.cross_inertia + b.mass * b.x * b.h;
        i += 1;
    }
    Lumps {
        total_mass: m,
        cog_to_rear: mx / m,
        cog_height: mh / m,
        roll_inertia: xx,
        yaw_inertia: zz,
        cross_inertia: xz,
    }
}

/// The lumps of bicycle and rider with the load on board: `rear_load` [kg] with its centre of mass
/// at (`rear_load_x`, `rear_load_h`) and its own radii of gyration, all in [m].
pub fn loaded<T: Real>(p: &Parameters<T>) -> Lumps<T> {
    let (m, x, h) = (p.rear_load, p.rear_load_x, p.rear_load_h);
    let (k_xx, k_zz) = (p.rear_load_roll_gyration, p.rear_load_yaw_gyration);
    let total = p.total_mass + m;
    Lumps {
        total_mass: total,
        // M L_1 + m x over the sum, written so that m = 0 leaves L_1 to the last bit
        cog_to_rear: p.cog_to_rear + m * (x - p.cog_to_rear) / total,
        cog_height: p.cog_height + m * (h - p.cog_height) / total,
        roll_inertia: p.roll_inertia + m * (h * h + k_xx * k_xx),
        yaw_inertia: p.yaw_inertia + m * (x * x + k_zz * k_zz),
        cross_inertia: p.cross_inertia + m * x * h,
    }
}

impl Lumps {
    /// What is left of these bodies without `part`, as one body.
    #[must_use]
    pub fn without(&self, part: &Body) -> Body {
        let removed = Body {
            mass: -part.mass,
            roll_inertia: -part.roll_inertia,
            yaw_inertia: -part.yaw_inertia,
            cross_inertia: -part.cross_inertia,
            ..*part
        };
        compose(&[self.body(), removed]).body()
    }

    /// The same set of bodies as one rigid body: inertias about its centre of mass.
    pub fn body(&self) -> Body {
        let Self {
            total_mass: m,
            cog_to_rear: x,
            cog_height: h,
            ..
        } = *self;
        Body {
            mass: m,
            x,
            h,
            roll_inertia: self.roll_inertia - m * h * h,
            yaw_inertia: self.yaw_inertia - m * x * x,
            cross_inertia: self.cross_inertia - m * x * h,
        }
    }

    /// With the centre of mass moved to (`cog_to_rear`, `cog_height`) [m] and the inertias about
    /// the centre of mass kept: what a sweep of the centre of mass means.
    #[must_use]
    pub fn moved(&self, cog_to_rear: f64, cog_height: f64) -> Self {
        compose(&[Body {
            x: cog_to_rear,
            h: cog_height,
            ..self.body()
        }])
    }
}

/// The 25 parameters of the literature (Meijaard et al. 2007, Table 1), symbols and signs as
/// there: **z down**, x forward, origin at the rear contact; `IByy` and `IHyy` play no part.
/// `c` is the trail. This type is the marked door for the literature's signs.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(non_snake_case, missing_docs, reason = "the literature's symbols")]
pub struct Literature {
    pub w: f64,
    pub c: f64,
    pub lam: f64,
    pub rR: f64,
    pub mR: f64,
    pub IRxx: f64,
    pub IRyy: f64,
    pub xB: f64,
    pub zB: f64,
    pub mB: f64,
    pub IBxx: f64,
    pub IBzz: f64,
    pub IBxz: f64,
    pub xH: f64,
    pub zH: f64,
    pub mH: f64,
    pub IHxx: f64,
    pub IHzz: f64,
    pub IHxz: f64,
    pub rF: f64,
    pub mF: f64,
    pub IFxx: f64,
    pub IFyy: f64,
}

impl Literature {
    /// The four bodies: rear wheel, rear frame (with a rigid rider where there is one), front
    /// frame, front wheel.
    pub fn bodies(&self) -> [Body; 4] {
        // z down → h up: h = −z, and the product of inertia about up-pointing axes, in the sense
        // of Σ(I_xz + m x h), is the literature's I_xz with its sign kept: Meijaard's (A 4) adds
        // −m x z = m x h to I_xz.
        let body = |mass, x, z: f64, xx, zz, xz| Body {
            mass,
            x,
            h: -z,
            roll_inertia: xx,
            yaw_inertia: zz,
            cross_inertia: xz,
        };
        [
            body(self.mR, 0.0, -self.rR, self.IRxx, self.IRxx, 0.0),
            body(self.mB, self.xB, self.zB, self.IBxx, self.IBzz, self.IBxz),
            body(self.mH, self.xH, self.zH, self.IHxx, self.IHzz, self.IHxz),
            body(self.mF, self.w, -self.rF, self.IFxx, self.IFxx, 0.0),
        ]
    }

    /// The front assembly: front frame and wheel as one body.
    pub fn front_assembly(&self) -> Body {
        let [_, _, frame, wheel] = self.bodies();
        compose(&[frame, wheel]).body()
    }

    /// Writes the rows that the 25 parameters determine into `p`, with `riders` on board besides.
    pub fn write(&self, p: &mut Parameters, riders: &[Body]) {
        let bodies: Vec<Body> = self.bodies().iter().chain(riders).copied().collect();
        p.set_lumps(compose(&bodies));
        p.wheelbase = self.w;
        p.trail = self.c;
        p.caster_angle = self.lam;
        p.rear_wheel_radius = self.rR;
        p.front_wheel_radius = self.rF;
        p.front_wheel_mass = self.mF;
        p.front_wheel_inertia = self.IFyy;
        p.rear_wheel_inertia = self.IRyy;
        p.set_front_assembly(self.front_assembly());
        p.steer_inertia = FourBodies::new(p, &p.lumps()).steer_inertia;
    }
}
