// A side (0-5: +x -x +y -y +z -z) of a dense cell in a list of work; code: of the cell, cascade above Morton code.
uint side_item(uint code, int side) { return code | uint(side) << 29; }
uint side_item_code(uint item) { return item & 0x1FFFFFFFu; }
int side_item_side(uint item) { return int(item >> 29); }
