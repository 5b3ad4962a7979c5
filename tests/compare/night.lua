-- A character that glows walks at night between pillars: there is no other light.
kandil.scene { size = {320, 180}, fps = 24, seconds = 2, exposure_ev = 1 }
kandil.spawn { mesh = { shape = "plane", size = {12, 1, 12} }, material = { base_color = {0.6, 0.58, 0.55} } }
kandil.spawn { mesh = { shape = "box", size = {12, 4, 0.3} }, material = { base_color = {0.5, 0.2, 0.15} },
               transform = { position = {0, 2, -3} } }
for i = -2, 2 do
    kandil.spawn { mesh = { shape = "cylinder", size = {0.4, 3, 0.4} }, material = { base_color = {0.7, 0.7, 0.7} },
                   transform = { position = {1.6 * i, 1.5, -1.2} } }
end
local robot = kandil.spawn { model = "robot/robot.glb", animation = { clip = "Robot_Walking", loop = true },
                             material = { base_color = {0.2, 0.2, 0.2}, emissive = {3, 2, 0.8} },
                             transform = { position = {-2, 0, 0}, rotation_deg = {0, 90, 0}, scale = {0.35, 0.35, 0.35} } }
kandil.spawn { camera = { fov_y_deg = 45 }, transform = { position = {0.5, 1.9, 6}, look_at = {0, 1.1, -1} } }
function kandil.update(t)
    robot.transform.position = {-2 + 0.9 * t, 0, 0}
end
