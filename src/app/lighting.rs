//! What lights a scene: where its sun stands, and what is around it.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use glam::Vec3;

use crate::environment::{self, DEFAULT_DIRECTION_TO_SUN, Environment};
use crate::scene::{Light, LitBy, Scene, SkySun};
use crate::settings::{EnvironmentSettings, EnvironmentSource, SunPlace};
use crate::{Error, Result};

/// Puts a scene's sun where it is asked for and the scene into its environment, whose suns become lights of the scene.
///
/// # Errors
/// [`Error::Usage`] when there is no sun to be placed, [`Error::File`] when the environment's image cannot be read.
pub(super) fn light(scene: &mut Scene, sun: Option<SunPlace>, settings: &EnvironmentSettings) -> Result<()> {
    let source = source(scene, settings);
    warn(scene, settings, &source);
    if source != EnvironmentSource::None && scene.lit_by != LitBy::Lights {
        // The default sun is for scenes without any light.
        scene.lights.clear();
    }
    if let Some(sun) = sun {
        match first_sun(scene).and_then(|index| direction_mut(&mut scene.lights[index])) {
            Some(direction_ws) => *direction_ws = sun.travel_ws(),
            // The sky brings the sun.
            None if source == EnvironmentSource::Sky => {}
            None => return Err(Error::Usage("--sun needs a directional light, and the scene has none".to_owned())),
        }
    }
    let environment = match &source {
        EnvironmentSource::None => None,
        EnvironmentSource::Uniform(radiance) => Some(Environment::uniform(*radiance)),
        EnvironmentSource::File(path) => Some(read(path)?),
        EnvironmentSource::Sky => Some(put_under_sky(scene, sun, settings.turn_deg)),
    };
    if let Some(environment) = environment {
        scene.lights.extend(suns(&environment, settings));
        scene.environment = Some(Arc::new(environment));
    }
    if scene.lights.is_empty() {
        scene.lights.push(Light::DARK);
    }
    Ok(())
}

/// After the scene's lights have moved: keeps a sun that was placed where it is, and makes the sky anew for a sun that is not
/// where or what it was. Whether it has.
pub(super) fn follow(scene: &mut Scene, sun: Option<SunPlace>, settings: &EnvironmentSettings) -> bool {
    let held = sun.zip(first_sun(scene).filter(|index| scene.motion.moves_light(*index)));
    if let Some((sun, direction_ws)) = held.and_then(|(sun, i)| Some((sun, direction_mut(&mut scene.lights[i])?))) {
        *direction_ws = sun.travel_ws();
    }
    let Some(before) = scene.sky_sun.filter(|sun| sun.moves) else { return false };
    let Some(now) = before.own.and_then(|index| sky_sun(scene, index, settings.turn_deg)) else { return false };
    if now == before {
        return false;
    }
    let start = Instant::now();
    scene.sky_sun = Some(now);
    scene.environment = Some(Arc::new(sky_of(now)));
    log::debug!("sky: made in {:.1} ms", start.elapsed().as_secs_f64() * 1e3);
    true
}

/// Where a scene's light from all around comes from.
pub(super) fn source(scene: &Scene, settings: &EnvironmentSettings) -> EnvironmentSource {
    match &settings.source {
        Some(source) => source.clone(),
        None if has_sky_for_lack_of_light(scene, settings) => EnvironmentSource::Sky,
        None => EnvironmentSource::None,
    }
}

/// Whether a scene stands under a sky because it brings no light and nothing else is asked for.
pub(super) fn has_sky_for_lack_of_light(scene: &Scene, settings: &EnvironmentSettings) -> bool {
    settings.source.is_none() && scene.lit_by == LitBy::Nothing
}

/// Says what a scene without lights is lit by.
fn warn(scene: &Scene, settings: &EnvironmentSettings, source: &EnvironmentSource) {
    if has_sky_for_lack_of_light(scene, settings) {
        log::warn!("the scene has no light: a clear sky lights it; --environment none gives it a sun alone");
    } else if *source == EnvironmentSource::None && scene.lit_by == LitBy::Nothing {
        log::info!("the scene has no light: a default sun shines");
    } else if *source == EnvironmentSource::None && scene.lit_by == LitBy::EmissiveSurfaces {
        log::info!("the scene has no light but surfaces that shine; --environment sky puts it under a sky");
    }
}

/// The environment of an image, its suns taken out.
fn read(path: &Path) -> Result<Environment> {
    let environment = environment::file::read(path)?.with_suns_apart();
    if !environment.suns.is_empty() {
        let (file, count) = (path.display(), environment.suns.len());
        log::info!("{file}: {count} small sun(s) of the environment shine as directional lights");
    }
    Ok(environment)
}

/// A clear sky around the scene's first sun, or with a sun of its own.
fn put_under_sky(scene: &mut Scene, placed: Option<SunPlace>, turn_deg: f32) -> Environment {
    let own = first_sun(scene).and_then(|index| sky_sun(scene, index, turn_deg));
    let brought = || SkySun {
        towards: placed.map_or(DEFAULT_DIRECTION_TO_SUN.normalize(), |sun| before_turn(sun.travel_ws(), turn_deg)),
        irradiance: Vec3::ZERO,
        own: None,
        moves: false,
    };
    let sun = own.unwrap_or_else(brought);
    scene.sky_sun = Some(sun);
    sky_of(sun)
}

/// The sky for a sun.
fn sky_of(sun: SkySun) -> Environment {
    match sun.own {
        Some(_) => Environment::sky_for_sun(sun.towards, sun.irradiance, sun.moves),
        None => Environment::sky_with_sun(sun.towards),
    }
}

/// Where the light of a sun comes from, in a sky that is turned then: the sun that is there stays where it is.
fn before_turn(travel_ws: Vec3, turn_deg: f32) -> Vec3 {
    environment::turned(-travel_ws, -turn_deg)
}

/// A directional light of the scene as the sun of a sky.
fn sky_sun(scene: &Scene, index: usize, turn_deg: f32) -> Option<SkySun> {
    let Light::Directional { direction_ws, irradiance } = scene.lights.get(index)? else { return None };
    let towards = before_turn(*direction_ws, turn_deg);
    Some(SkySun { towards, irradiance: *irradiance, own: Some(index), moves: scene.motion.moves_light(index) })
}

/// The first directional light that shines, be it at another moment.
fn first_sun(scene: &Scene) -> Option<usize> {
    let mut brightest = scene.motion.brightest_of(&scene.lights);
    brightest.position(|light| matches!(light, Light::Directional { .. }) && !light.is_dark())
}

fn direction_mut(light: &mut Light) -> Option<&mut Vec3> {
    match light {
        Light::Directional { direction_ws, .. } => Some(direction_ws),
        _ => None,
    }
}

/// The suns of an environment as lights, turned and scaled with it.
pub(super) fn suns(environment: &Environment, settings: &EnvironmentSettings) -> impl Iterator<Item = Light> {
    let (scale, turn_deg) = (settings.scale, settings.turn_deg);
    environment.suns.iter().map(move |sun| Light::Directional {
        direction_ws: -environment::turned(sun.direction_to_sun, turn_deg),
        irradiance: sun.irradiance * scale,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::setup::read_scene;
    use crate::scene::testing::{diffuse, scene_from_quads};
    use crate::settings::MotionSettings;

    const QUAD: [Vec3; 4] = [Vec3::ZERO, Vec3::Z, Vec3::new(1.0, 0.0, 1.0), Vec3::X];

    fn scene(lights: Vec<Light>, lit_by: LitBy) -> Scene {
        Scene { lights, lit_by, ..scene_from_quads("test", &[QUAD], diffuse("white", Vec3::ONE)) }
    }

    fn lit(lights: Vec<Light>, sun: Option<SunPlace>, settings: &EnvironmentSettings) -> Scene {
        let mut scene = scene(lights, LitBy::Lights);
        light(&mut scene, sun, settings).unwrap();
        scene
    }

    fn under(source: EnvironmentSource) -> EnvironmentSettings {
        EnvironmentSettings { source: Some(source), ..EnvironmentSettings::default() }
    }

    fn point() -> Light {
        Light::Point { position_ws: Vec3::ONE, intensity: Vec3::ONE }
    }

    fn own_sun() -> Light {
        Light::Directional { direction_ws: Vec3::new(0.6, -0.8, 0.0), irradiance: Vec3::splat(3.0) }
    }

    /// Azimuth and height of the brightest texel of the scene's sky, turned, in degrees.
    fn brightest(scene: &Scene, turn_deg: f32) -> SunPlace {
        let sky = scene.environment.as_ref().unwrap();
        let brightest = sky.radiance.iter().enumerate().max_by(|a, b| a.1[1].total_cmp(&b.1[1])).unwrap().0 as u32;
        let point = [brightest % sky.size[0], brightest / sky.size[0]];
        let point = [0, 1].map(|axis| (point[axis] as f32 + 0.5) / sky.size[axis] as f32);
        SunPlace::towards(environment::turned(environment::image_direction(point), turn_deg))
    }

    #[test]
    fn a_uniform_environment_brings_no_sun_and_takes_the_default_one() {
        let settings = under(EnvironmentSource::Uniform([1.0; 3]));
        for lit_by in [LitBy::Nothing, LitBy::EmissiveSurfaces] {
            let mut scene = scene(vec![own_sun()], lit_by);
            light(&mut scene, None, &settings).unwrap();
            assert_eq!(scene.lights, [Light::DARK]);
        }
        assert_eq!(lit(vec![own_sun()], None, &settings).lights, [own_sun()]);
        let none = lit(vec![point()], None, &under(EnvironmentSource::None));
        assert!(none.environment.is_none() && none.lights == [point()]);
    }

    #[test]
    fn a_scene_without_any_light_stands_under_a_sky() {
        let default_sun = own_sun();
        let under = |lit_by: LitBy, source: Option<EnvironmentSource>| {
            let mut scene = scene(vec![default_sun.clone()], lit_by);
            light(&mut scene, None, &EnvironmentSettings { source, ..EnvironmentSettings::default() }).unwrap();
            (scene.environment.is_some(), scene.lights == [default_sun.clone()])
        };
        assert_eq!(under(LitBy::Nothing, None), (true, false));
        assert_eq!(under(LitBy::Nothing, Some(EnvironmentSource::None)), (false, true));
        for lit_by in [LitBy::Lights, LitBy::EmissiveSurfaces] {
            assert_eq!(under(lit_by, None), (false, true));
        }
    }

    #[test]
    fn a_sky_is_for_the_sun_of_the_scene() {
        let place = SunPlace { azimuth_deg: 130.0, height_deg: 40.0 };
        let at = |found: SunPlace, place: SunPlace| {
            (found.azimuth_deg - place.azimuth_deg).abs() < 3.0 && (found.height_deg - place.height_deg).abs() < 3.0
        };
        for turn_deg in [0.0, 70.0] {
            let settings = EnvironmentSettings { turn_deg, scale: 2.0, ..under(EnvironmentSource::Sky) };
            // Its own sun stays the sun.
            let own = lit(vec![point(), own_sun()], None, &settings);
            assert_eq!(own.lights, [point(), own_sun()]);
            assert!(at(brightest(&own, turn_deg), SunPlace::towards(Vec3::new(-0.6, 0.8, 0.0))), "turned {turn_deg}");
            assert_eq!(lit(vec![own_sun()], Some(place), &settings).lights.len(), 1);
            // A lamp is no sun: the sky brings one.
            let placed = lit(vec![point()], Some(place), &settings);
            let [_, Light::Directional { direction_ws, .. }] = placed.lights[..] else { panic!("{:?}", placed.lights) };
            assert!(direction_ws.distance(place.travel_ws()) < 1e-4, "turned {turn_deg}: {direction_ws}");
            assert!(at(brightest(&placed, turn_deg), place), "turned {turn_deg}");
        }
        let plain = lit(vec![point()], None, &under(EnvironmentSource::Sky));
        let turned = EnvironmentSettings { turn_deg: 90.0, scale: 2.0, ..under(EnvironmentSource::Sky) };
        let turned = lit(vec![point()], None, &turned);
        let sun = |scene: &Scene| match scene.lights[1] {
            Light::Directional { direction_ws, irradiance } => (direction_ws, irradiance),
            _ => panic!("{:?}", scene.lights),
        };
        assert_eq!(plain.environment, turned.environment, "it is turned and scaled when it is rendered");
        assert!((sun(&turned).1 - 2.0 * sun(&plain).1).length() < 1e-4);
        assert!(environment::turned(sun(&plain).0, 90.0).distance(sun(&turned).0) < 1e-5);
    }

    /// The built-in scene under a sky at a moment of one of its animations.
    fn courtyard(animation: &str, time_s: f64, sun: Option<SunPlace>) -> Scene {
        let motion = MotionSettings { time_s, animation: Some(animation.to_owned()), ..MotionSettings::default() };
        read_scene((None, true), sun, &motion, &under(EnvironmentSource::Sky), &|_, _, _| ()).unwrap()
    }

    #[test]
    fn a_sky_follows_the_sun_of_its_scene() {
        let settings = under(EnvironmentSource::Sky);
        let mut scene = courtyard("sun", 0.0, None);
        let first = scene.environment.clone();
        assert!(!follow(&mut scene, None, &settings), "nothing has moved");
        scene.pose(3.0);
        assert!(follow(&mut scene, None, &settings));
        let there = courtyard("sun", 3.0, None);
        assert!(scene.environment == there.environment && scene.environment != first);
        assert_eq!((scene.sky_sun, &scene.lights), (there.sky_sun, &there.lights));
        // It is turned with the sky.
        let turned = EnvironmentSettings { turn_deg: 30.0, ..settings.clone() };
        assert!(follow(&mut scene, None, &turned) && scene.environment != there.environment);
        assert!(follow(&mut scene, None, &settings) && scene.environment == there.environment);
        // Lit by day again, it is black while the sun is out, and keeps its size.
        let index = scene.sky_sun.unwrap().own.unwrap();
        let sun = scene.lights[index].clone();
        scene.lights[index] = Light::Directional { direction_ws: Vec3::NEG_Y, irradiance: Vec3::ZERO };
        assert!(follow(&mut scene, None, &settings));
        let night = scene.environment.clone().unwrap();
        assert!(
            night.size == there.environment.as_ref().unwrap().size && night.radiance.iter().all(|c| *c == [0.0; 3])
        );
        scene.lights[index] = sun;
        assert!(follow(&mut scene, None, &settings) && scene.environment == there.environment);
    }

    #[test]
    fn a_sky_stays_where_its_sun_does() {
        let settings = under(EnvironmentSource::Sky);
        let place = Some(SunPlace { azimuth_deg: 130.0, height_deg: 40.0 });
        for (animation, place) in [("sun", place), ("figure", None)] {
            let mut scene = courtyard(animation, 0.0, place);
            let first = scene.environment.clone().unwrap();
            scene.pose(3.0);
            assert!(!follow(&mut scene, place, &settings), "{animation}");
            assert!(Arc::ptr_eq(scene.environment.as_ref().unwrap(), &first), "{animation}");
        }
    }

    #[test]
    fn a_sun_that_is_not_there_cannot_be_placed() {
        let place = Some(SunPlace { azimuth_deg: 0.0, height_deg: 40.0 });
        for source in [EnvironmentSource::None, EnvironmentSource::Uniform([1.0; 3])] {
            let error = light(&mut scene(vec![point()], LitBy::Lights), place, &under(source)).unwrap_err();
            assert!(
                error.exit_code() == 2 && error.to_string().starts_with("--sun needs a directional light"),
                "{error}"
            );
        }
    }
}
