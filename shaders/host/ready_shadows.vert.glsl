#version 120
// A rectangle over the picture: corners at -1 and 1.
void main() { gl_Position = vec4(gl_Vertex.xy, 0.0, 1.0); }
