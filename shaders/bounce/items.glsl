// Sides of dense cells whose turn it is, in any order. Buffer "bounce.items": arguments of an indirect dispatch of groups of 64,
// the count, and the items: Morton code of the dense cell with its cascade above | side << 29 (+x -x +y -y +z -z).
layout(std430, binding = 0) KD_ITEMS_ACCESS buffer items_block {
    uint items_args[3];
    uint items_count;
    uint items[];
};
