-- Another scene standing still, seen by a camera that goes slowly aside and forwards, 0.3 m/s: for
-- tests/compare/steady.sh.
require(kandil.param("scene", "cornell"))

local eye
for e in kandil.query("camera", "transform") do
    eye = eye or e
end
for e in kandil.query("animation") do
    e:set("animation.speed", 0)
end
local from = eye:get("transform.position")

function kandil.update(t)
    eye.transform.position = {from[1] + 0.26 * t, from[2], from[3] - 0.15 * t}
end
