// The part of three.js that the page uses; see build.sh.
export {
    AmbientLight, BoxGeometry, BufferAttribute, BufferGeometry, Color, DoubleSide, FrontSide, BackSide, GLSL3, Group,
    LineBasicMaterial, LineSegments, Matrix4, Mesh, OrthographicCamera, PerspectiveCamera, Plane, Points, Scene,
    ShaderMaterial, Vector2, Vector3, Vector4, WebGLRenderer,
} from 'three';
