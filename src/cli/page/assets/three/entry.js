// The part of three.js that the page uses; see build.sh.
export {
    AmbientLight, BackSide, BoxGeometry, BufferAttribute, BufferGeometry, Color, ColorManagement, DoubleSide, FrontSide, GLSL3, Group, LinearSRGBColorSpace,
    LineBasicMaterial, LineSegments, Matrix4, Mesh, OrthographicCamera, PerspectiveCamera, Plane, Points, Scene,
    ShaderMaterial, Vector2, Vector3, Vector4, WebGLRenderer,
} from 'three';
