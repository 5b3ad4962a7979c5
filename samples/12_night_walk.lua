-- The only light is the creature itself: it glows, walks, and lights the room as it goes. Its voxels move with its
-- skin, and so does its light.
kandil.scene { size = {640, 360}, fps = 24, seconds = 4, exposure_ev = 1.5 }

kandil.spawn { model = "assets/cornell.gltf" }
for i = -1, 1 do
    kandil.spawn {
        mesh = { shape = "box", size = {0.22, 0.5 + 0.2 * i, 0.22} },
        material = { base_color = {0.7, 0.7, 0.7} },
        transform = { position = {0.55 * i, 0.25 + 0.1 * i, -0.5}, rotation_deg = {0, 25 * i, 0} },
    }
end
local walker = kandil.spawn {
    name = "walker",
    model = "assets/walker.gltf",
    material = { base_color = {0.2, 0.1, 0.05}, emissive = {2, 1, 0.35} },
    animation = { clip = "walk", loop = true },
}
kandil.spawn { camera = { fov_y_deg = 40 }, transform = { position = {0, 0.85, 2.3}, look_at = {0, 0.62, 0} } }

function kandil.update(t)
    walker.transform.position = {-0.8 + 0.4 * t, 0, 0.2}
    walker.transform.rotation_deg = {0, 90, 0}
end
