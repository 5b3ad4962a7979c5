-- A subdivision surface: the dragon as a cage of some 700 quads whose limit surface walks. Its soles have creased rims.
-- `--set subdiv.level=1` … 5 shows it coarser or finer.
kandil.scene { size = {640, 360}, fps = 24, seconds = 2, gi = "cones" }

kandil.spawn { -- a little from above, from its left side
    name = "camera",
    camera = { fov_y_deg = 32 },
    transform = { position = {2.1, 0.75, 0.15}, look_at = {0, 0.45, 0} },
}
kandil.spawn {
    name = "ground",
    mesh = { shape = "box", size = {6, 0.1, 6} },
    material = { base_color = {0.55, 0.6, 0.65}, roughness = 0.9 },
    transform = { position = {0, -0.05, 0} },
}
kandil.spawn {
    name = "wall",
    mesh = { shape = "box", size = {0.1, 3, 6} },
    material = { base_color = {0.25, 0.45, 0.8}, roughness = 0.9 },
    transform = { position = {-0.8, 1.5, 0} },
}
kandil.spawn {
    name = "sun",
    light = { type = "directional", intensity = 3 },
    transform = { look_at = {-0.7, -1, -0.35} },
}
kandil.spawn {
    name = "walker",
    model = "assets/walker_cage.gltf",
    animation = { clip = "walk", loop = true },
}
