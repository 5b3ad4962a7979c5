-- One scene for comparing: `kandil run samples/14_techniques.lua --gi none`, `--gi cones`, with
-- `--set light.bounces=0`, `1` or `inf`; `kandil reference` path traces it, `kandil compare` puts figures to both.
kandil.scene { size = {640, 360}, fps = 24, seconds = 1 }

kandil.spawn { model = "assets/cornell.gltf" }
kandil.spawn { mesh = { shape = "box", size = {0.5, 1.1, 0.5} }, material = { base_color = {0.75, 0.75, 0.75} },
               transform = { position = {-0.35, 0.55, -0.3}, rotation_deg = {0, 18, 0} } }
kandil.spawn { mesh = { shape = "sphere", size = 0.6 }, material = { base_color = {0.9, 0.9, 0.9}, metallic = 1, roughness = 0.15 },
               transform = { position = {0.45, 0.3, 0.2} } }
kandil.spawn { light = { type = "spot", intensity = 22, inner_cone_deg = 20, outer_cone_deg = 60 },
               transform = { position = {0, 1.95, 0.1}, look_at = {0, 0, 0} } }
kandil.spawn { camera = { fov_y_deg = 40 }, transform = { position = {0, 0.85, 2.5}, look_at = {0, 0.66, 0} } }
