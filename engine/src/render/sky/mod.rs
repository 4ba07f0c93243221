//! The sky's light: in come its radiance and the scene's surfaces, out goes what they reflect of it, for methods of
//! indirect light that contribute none of it. What lies behind everything is drawn when the light is put together.

pub(super) mod sky_light;
